"""examples/tiny, the foreign renderer in C++: built, run, and held against exact answers, with fixed seeds.

Its output goes through the EXR reader alone, none of our renderers takes part.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from scenes import Case, Scene
from scenes.channels import single_channel
from scenes.features import features
from scenes.formats import exr, finished
from scenes.library import CASES, case

REPLICATES = 8

Images = NDArray[np.float64]
Run = Callable[..., "subprocess.CompletedProcess[str]"]
Render = Callable[..., Images]

pytestmark = pytest.mark.xdist_group("tiny")  # built once, for docs/test_foreign_renderer.py too


@pytest.fixture
def program(tiny: Path) -> Path:
    return tiny / "tiny"


@pytest.fixture
def run(program: Path, tmp_path: Path) -> Run:
    def run(scene: Scene | bytes, *options: object) -> subprocess.CompletedProcess[str]:
        content = scene if isinstance(scene, bytes) else scene.to_json()
        (tmp_path / "scene.json").write_bytes(content)
        arguments = [program, tmp_path / "scene.json", *options, "-o", tmp_path / "image.exr"]
        return subprocess.run([*map(str, arguments)], capture_output=True, text=True, timeout=120)

    return run


@pytest.fixture
def render(run: Run, tmp_path: Path) -> Render:
    """Images of all bounces, or, without ``bounces`` or with ``layers=False``, of their sum."""

    def render(scene: Scene, spp: int, seed: int, bounces: int | None = None, layers: bool = True) -> Images:
        options = ["--spp", spp, "--seed", seed]
        options += [] if bounces is None else ["--bounces", bounces, *(["--layers"] if layers else [])]
        found = run(scene, *options)
        assert found.returncode == 0, found.stderr
        layered = bounces is not None and layers
        return finished.read(tmp_path / "image.exr", layered, scene.channels).images

    return render


def bias(images: Images, truth: Images) -> tuple[Images, Images]:
    """Of replicates ``(replicates, …, height, width, channels)``: relative bias of the image, standard error."""
    means = images.mean(axis=(-3, -2)) / truth.mean(axis=(-3, -2))
    return means.mean(axis=0) - 1, means.std(axis=0, ddof=1) / np.sqrt(len(means))


@cache
def known(name: str) -> tuple[Case, Images]:
    found = case(name)
    return found, found.answer.truth(found.scene, found.bounces).mean


EXACT = {
    "furnace-channels": 0.002,
    "furnace-mirrors": 0.001,
    "integrating-sphere": 0.002,
    "quad-over-plane": 0.003,
    "triangle-over-plane": 0.003,
    "disk-over-plane": 0.003,
    "disk-shadow": 0.001,
    "spot-falloff": 0.001,
    "lit-from-behind": 0.015,
    "wall-by-reflection": 0.015,
    "mirror-lamps": 0.01,
    "glass-slab": 0.03,
    "lamp-under-water": 0.002,
}
"""Cases that use all it has, and four standard errors with the samples taken here: the error that would be seen."""


@pytest.mark.parametrize("name", EXACT)
def test_every_bounce_agrees_with_the_exact_answer(name: str, render: Render) -> None:
    found, truth = known(name)
    images = np.stack([render(found.scene, 32, seed, found.bounces) for seed in range(REPLICATES)])
    assert images.shape[1:] == truth.shape
    lit = truth.mean(axis=(1, 2, 3)) > 0
    assert (images[:, ~lit] == 0).all()
    relative, stderr = bias(images[:, lit], truth[lit])
    assert 4 * stderr.max() < EXACT[name]
    # t with 7 degrees of freedom exceeds 7 in 1 of 5,000 looks; there are up to 15 of them here
    assert (np.abs(relative) < 7 * stderr + 1e-6).all()


@pytest.mark.parametrize("name", ["mirror-lamps", "wall-by-reflection"])  # pinhole and orthographic
def test_the_image_is_not_turned_over(name: str, render: Render) -> None:
    """Quarters of the image, whose order tells up from down and left from right."""

    def quarters(image: Images) -> Images:
        return np.array([[half.mean() for half in np.hsplit(rows, 2)] for rows in np.vsplit(image, 2)])

    found, truth = known(name)
    image, expected = render(found.scene, 64, 1, found.bounces).sum(axis=0), truth.sum(axis=0)
    distances = {
        turned: np.abs(quarters(image) - quarters(expected[::rows, ::columns])).max()
        for turned, (rows, columns) in {
            "not": (1, 1),
            "over": (-1, 1),
            "around": (1, -1),
            "both": (-1, -1),
        }.items()
    }
    assert distances.pop("not") < 0.02 * expected.mean()
    assert min(distances.values()) > 0.05 * expected.mean()


def test_the_same_seed_gives_the_same_image_and_another_one_another(render: Render) -> None:
    scene = case("cornell-box").scene.resized(16, 16)
    images = [render(scene, 4, seed, 2) for seed in (1, 1, 2)]
    assert (images[0] == images[1]).all()
    assert (images[0] != images[2]).any()


def test_sums_are_sums_of_the_layers_and_share_their_paths(render: Render) -> None:
    scene = case("cornell-box").scene.resized(16, 16)
    layers = render(scene, 4, 1, 3)
    for bounces in range(4):
        [image] = render(scene, 4, 1, bounces, layers=False)
        np.testing.assert_allclose(image, layers[: bounces + 1].sum(axis=0), rtol=1e-5)


@pytest.mark.parametrize("name", ["furnace-channels", "furnace-mirrors"])
def test_without_a_depth_it_gives_the_sum_of_all_bounces(name: str, render: Render) -> None:
    scene = case(name).scene.resized(32, 32)
    infinite = case(name).answer.truth(scene, 400).mean.sum(axis=0)
    images = np.stack([render(scene, 32, seed) for seed in range(REPLICATES)])
    relative, stderr = bias(images[:, 0], infinite)
    assert 4 * stderr.max() < 0.02
    assert (np.abs(relative) < 7 * stderr).all()


def test_one_channel_is_grey(render: Render, tmp_path: Path) -> None:
    scene = case("furnace-channels").scene.resized(8, 8)
    image = render(single_channel(scene, 1), 4, 1, 2)
    np.testing.assert_array_equal(image[..., 0], render(scene, 4, 1, 2)[..., 1])
    assert exr.read_wavelengths(tmp_path / "image.exr") is None


def test_a_case_is_rendered_or_refused_by_what_it_has(run: Run) -> None:
    refused = 0
    for name in CASES:
        scene = case(name).scene
        found = run(scene, "--spp", 1, "--bounces", 0)
        if found.returncode:
            told = found.stderr.splitlines()[-1]
            assert (found.returncode, told[:13]) == (3, "unsupported: "), name
            assert told[13:] in features(scene), name
            refused += 1
    assert len(CASES) - refused == 56  # as the page says


def test_a_field_that_it_does_not_know_is_refused(run: Run) -> None:
    scene = case("furnace-box").scene
    wall = msgspec.structs.replace(scene.surfaces[0], two_sided=True)
    found = run(msgspec.structs.replace(scene, surfaces=(wall, *scene.surfaces[1:])), "--spp", 1)
    assert (found.returncode, found.stderr) == (3, "unsupported: two_sided\n")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--spp", "0"], "--spp 0: expected a whole number, 1 or more"),
        (["--spp", "4x"], "--spp 4x: expected a whole number, 1 or more"),
        (["--bounces", "-1"], "--bounces -1: expected a whole number, 0 or more"),
        (["--layers"], "--layers: expected --bounces as well"),
        (["--depth", "3"], "--depth: no such option"),
    ],
)
def test_wrong_usage(options: list[str], message: str, run: Run) -> None:
    found = run(case("furnace-box").scene, *options)
    assert found.returncode == 2
    assert message in found.stderr


def test_what_is_no_scene(run: Run) -> None:
    found = run(b"{", "--spp", 1)
    assert found.returncode == 1
    assert "parse error" in found.stderr
