"""Plugins from a Python file, made for real, stand in for Mitsuba's own."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import mitsuba as mi
import msgspec
import numpy as np
import pytest

from comparisons.renderers import RendererFailed, Unsupported
from comparisons.renderers.mitsuba import MitsubaRenderer
from comparisons.renderers.mitsuba_colours import colours
from comparisons.renderers.mitsuba_names import Form
from comparisons.renderers.mitsuba_plugin import (
    KINDS,
    MitsubaPlugin,
    MitsubaPluginRenderer,
    PluginError,
    entry,
    supports,
)
from comparisons.renderers.mitsuba_scene import scene_dict
from scenes import Scene, Sphere, library

PLUGINS = '''
import drjit as dr
import mitsuba as mi


class MyDiffuse(mi.BSDF):
    """Lambert's, by other means than Mitsuba's: directions uniform over the hemisphere."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.albedo, self.gain = props.get_texture("albedo"), props.get("gain", 1.0)
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def sample(self, ctx, si, sample1, sample2, active):
        bs = mi.BSDFSample3f()
        bs.wo = mi.warp.square_to_uniform_hemisphere(sample2)
        bs.pdf = mi.warp.square_to_uniform_hemisphere_pdf(bs.wo)
        bs.eta, bs.sampled_type, bs.sampled_component = 1.0, +mi.BSDFFlags.GlossyReflection, 0
        return bs, self.eval(ctx, si, bs.wo, active) / bs.pdf

    def eval(self, ctx, si, wo, active):
        up = (mi.Frame3f.cos_theta(si.wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0)
        value = self.gain * self.albedo.eval(si, active) * mi.Frame3f.cos_theta(wo) / dr.pi
        return dr.select(up, value, mi.Spectrum(0.0))

    def pdf(self, ctx, si, wo, active):
        up = (mi.Frame3f.cos_theta(si.wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0)
        return dr.select(up, mi.warp.square_to_uniform_hemisphere_pdf(wo), 0.0)

    def eval_pdf(self, ctx, si, wo, active):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)


class MyPath(mi.SamplingIntegrator):
    """Mitsuba's, brighter by a gain, told how many bounces."""

    def __init__(self, props):
        mi.SamplingIntegrator.__init__(self, props)
        self.gain, last = props.get("gain", 1.0), props.get("last", -1)
        self.own = mi.load_dict({"type": "path", "max_depth": last + 1 if last >= 0 else -1, "rr_depth": 1000})

    def sample(self, scene, sampler, ray, medium, active):
        spectrum, valid, aovs = self.own.sample(scene, sampler, ray, medium, active)
        return self.gain * spectrum, valid, aovs


mi.register_bsdf("mydiffuse", MyDiffuse)
mi.register_integrator("mypath", MyPath)
'''

DIFFUSE = {"type": "mydiffuse", "albedo": "{reflectance}"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "my_plugins.py").write_text(PLUGINS)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def made(**table: Any) -> MitsubaPluginRenderer:
    return MitsubaPluginRenderer(msgspec.json.encode({"mitsuba": "scalar_rgb"} | table).decode())


def box() -> Scene:
    return library.case("furnace-box").scene.resized(4, 4)


@pytest.mark.usefixtures("folder")
def test_a_bsdf_of_ones_own() -> None:
    """In a furnace of albedo ½ bounce k is ½ᵏ; with a gain of 1.2, 0.6ᵏ."""
    for gain in (1.0, 1.2):
        table = DIFFUSE | {"gain": gain}
        mine = made(imports=["my_plugins.py"], bsdf={"diffuse": table})
        images = np.array([mine.render(box(), range(4), 64, seed).mean(axis=(1, 2, 3)) for seed in range(8)])
        error = images.std(axis=0, ddof=1) / np.sqrt(8)
        truth = (0.5 * gain) ** np.arange(4)
        assert (error < 0.03 * truth).all()
        np.testing.assert_array_less(np.abs(images.mean(axis=0) - truth), 5 * error + 1e-6)
    assert images.min() >= 0


@pytest.mark.usefixtures("folder")
def test_an_integrator_of_ones_own() -> None:
    """Told the last bounce, it numbers bounces as Mitsuba's path does, and its gain is seen in each."""
    integrator = {"type": "mypath", "last": "{bounces}", "gain": 2.0}
    mine = made(imports=["my_plugins.py"], integrator=integrator)
    theirs = MitsubaRenderer("scalar_rgb")
    view = library.case("cornell-box").scene.resized(4, 4)
    np.testing.assert_allclose(
        mine.render(view, range(4), 8, 3), 2 * theirs.render(view, range(4), 8, 3), rtol=1e-4, atol=1e-5
    )
    np.testing.assert_allclose(mine.total(box(), 256, 1).mean(), 4.0, rtol=0.05)
    assert mine.version() == theirs.version()


@pytest.mark.usefixtures("folder")
def test_an_integrator_that_is_told_no_depth_has_a_sum_alone() -> None:
    mine = made(imports=["my_plugins.py"], integrator={"type": "mypath", "gain": 1.0})
    with pytest.raises(Unsupported, match="per-bounce images: its integrator is told no depth"):
        mine.render(box(), [0, 1], 1, 0)
    assert mine.total(box(), 4, 1).shape == (4, 4, 3)


def test_a_sampler_an_emitter_and_a_shape_that_are_mitsubas_own() -> None:
    """What stands in is the same plugin: nothing changes, and children and properties are passed on."""
    same = {
        "emitter": {"area": {"type": "area", "radiance": "{radiance}"}},
        "shape": {"rectangle": {"type": "rectangle", "to_world": "{to_world}"}},
        "sampler": {"type": "independent"},
        "integrator": {"type": "path", "max_depth": "{max_depth}", "rr_depth": "{rr_depth}"},
    }
    np.testing.assert_array_equal(
        made(**same).render(box(), range(3), 4, 1),
        MitsubaRenderer("scalar_rgb").render(box(), range(3), 4, 1),
    )
    brighter = {"emitter": {"area": {"type": "area", "radiance": {"type": "rgb", "value": [3.0, 3.0, 3.0]}}}}
    np.testing.assert_allclose(made(**brighter).render(box(), [0], 4, 1), 3.0)


def test_what_is_not_passed_on_makes_a_scene_unsupported() -> None:
    sphere = {"sphere": {"type": "sphere", "to_world": "{to_world}"}}
    with pytest.raises(Unsupported, match=r"flip_normals of sphere: shape.sphere does not pass it on"):
        made(shape=sphere).render(library.case("furnace-sphere").scene.resized(4, 4), [0], 1, 0)


def test_what_a_scene_does_not_have_is_left_out() -> None:
    """A sphere seen from inside has ``flip_normals``, one from outside has not: one table does for both."""
    sphere = {"type": "sphere", "to_world": "{to_world}", "flip_normals": "{flip_normals}"}
    scene = library.case("concentric-spheres").scene.resized(8, 8)
    assert {surface.shape.inward for surface in scene.surfaces if isinstance(surface.shape, Sphere)} == {
        True,
        False,
    }
    mine, plain = made(shape={"sphere": sphere}), MitsubaRenderer("scalar_rgb")
    np.testing.assert_array_equal(mine.render(scene, [0, 1], 4, 1), plain.render(scene, [0, 1], 4, 1))


def test_what_is_known_before_it_is_loaded() -> None:
    table = {"mitsuba": "llvm_ad_rgb:direct", "bsdf": {"diffuse": DIFFUSE}, "sampler": {"type": "mine"}}
    known = entry(msgspec.convert(table, MitsubaPlugin))
    assert known.title == "mitsuba:llvm_ad_rgb:direct with sampler mine, bsdf mydiffuse"
    assert (known.module, known.adapter, known.package) == (
        "mitsuba_plugin",
        "MitsubaPluginRenderer",
        "mitsuba",
    )
    assert (known.last_bounce, known.spp_unit) == (1, 4)
    assert msgspec.json.decode(known.argument, type=MitsubaPlugin) == msgspec.convert(table, MitsubaPlugin)
    assert supports(known.argument)["images"] == ("bounces 0 and 1", "first hits")


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({"mitsuba": "scalar"}, "mitsuba: no renderer is called 'mitsuba:scalar': there is no variant"),
        ({"mitsuba": "scalar_rgb:prb"}, "such as mitsuba:llvm_ad_rgb:prb"),
        (
            {"bsdf": {"difuse": {"type": "x"}}},
            "bsdf: no bsdf plugin of the adapter is called 'difuse': did you mean",
        ),
        ({"bsdf": {"diffuse": {"kind": "x"}}}, "bsdf.diffuse: expected a table with the type"),
        (
            {"integrator": {"type": "x", "max_depth": "{depth}"}},
            r"integrator: {depth}: there are max_depth, bounces",
        ),
        ({"sampler": {"type": "x", "count": "{spp}"}}, r"sampler: {spp}: there are none"),
        (
            {"bsdf": {"diffuse": {"type": "x", "reflectance": "{reflectnce}"}}},
            r"bsdf.diffuse: {reflectnce}: there are reflectance",
        ),
    ],
)
def test_a_wrong_table(table: dict[str, Any], complaint: str) -> None:
    plugin = msgspec.convert({"mitsuba": "scalar_rgb"} | table, MitsubaPlugin)
    with pytest.raises(PluginError, match=complaint):
        plugin.check()


def test_every_property_that_the_adapter_gives_may_be_passed_on(tmp_path: Path) -> None:
    """In all scenes of the library together each of them comes up, and no other does."""
    mi.set_variant("scalar_rgb")
    found: dict[tuple[str, str], set[str]] = {}

    def look(part: dict[str, Any]) -> None:
        for kind, plugins in KINDS.items():
            if part.get("type") in plugins:
                found.setdefault((kind, part["type"]), set()).update(
                    part.keys() - {"type", "bsdf", "emitter"}
                )
        for value in part.values():
            if isinstance(value, dict):
                look(value)

    for name in library.CASES:
        scene = library.case(name).scene
        with suppress(Unsupported):
            look(scene_dict(colours(mi, Form(), scene.channels), scene, tmp_path))
    declared = {(kind, own): {*names} for kind, plugins in KINDS.items() for own, names in plugins.items()}
    for plugin, names in found.items():
        assert names <= declared[plugin], plugin
    unseen = {
        (*plugin, name) for plugin, names in declared.items() for name in names - found.get(plugin, set())
    }
    assert unseen == set()


def test_unknown_keys_are_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="bdsf"):
        msgspec.convert({"mitsuba": "scalar_rgb", "bdsf": {}}, MitsubaPlugin)


def test_a_file_that_is_not_there(folder: Path) -> None:
    with pytest.raises(RendererFailed, match=f"imports: there is no file {folder}/none.py"):
        made(imports=["none.py"])


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("what", ["bsdf", "integrator"])
def test_what_mitsuba_does_not_know_is_told_as_it_tells_it(what: str) -> None:
    unknown = {"type": "nobody", "max_depth": "{max_depth}"} if what == "integrator" else {"type": "nobody"}
    mine = made(**{what: unknown if what == "integrator" else {"diffuse": unknown | {"r": "{reflectance}"}}})
    with pytest.raises(Exception, match="nobody"):
        mine.render(box(), [0], 1, 0)
