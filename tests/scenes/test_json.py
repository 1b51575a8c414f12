"""A scene goes to JSON and back unchanged, and no JSON does more than be refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import AreaLight, Lambertian, Pinhole, PolarRange, Quad, Scene, SceneError, Sphere, Surface
from scenes.library import CASES, case

reproducible = settings(derandomize=True, deadline=None, database=None)

# ---- random scenes

coordinates = st.floats(-1e3, 1e3, allow_subnormal=False)
vectors = st.tuples(coordinates, coordinates, coordinates)


def not_parallel(a: Any, b: Any) -> bool:
    return bool(np.linalg.norm(np.cross(a, b)) > 1e-6 * np.linalg.norm(a) * np.linalg.norm(b) > 0)


edges = st.tuples(vectors, vectors).filter(lambda pair: not_parallel(*pair))
quads = st.builds(lambda corner, edges: Quad(corner, *edges), vectors, edges)
spheres = st.builds(Sphere, vectors, st.floats(1e-3, 1e3), st.booleans())
limits = st.tuples(st.floats(0, 90), st.floats(91, 180))
axes = vectors.filter(lambda axis: np.linalg.norm(axis) > 0)
zones = st.builds(lambda limits, axis: PolarRange(*limits, axis), limits, axes)
sensors = st.builds(
    lambda origin, directions, *rest: Pinhole(
        origin, tuple(np.add(origin, directions[0]).tolist()), directions[1], *rest
    ),
    vectors,
    edges,
    st.floats(1, 170),
    st.integers(1, 64),
    st.integers(1, 64),
)


@st.composite
def surfaces(draw: st.DrawFn, name: str, channels: int, emits: bool) -> Surface:
    shape = draw(quads | spheres)
    albedo = draw(st.tuples(*[st.floats(0, 1)] * channels))
    if not emits:
        return Surface(name, shape, Lambertian(albedo))
    radiance = draw(st.tuples(*[st.floats(0.01, 1e4)] * channels))
    zone = draw(st.none() | zones) if isinstance(shape, Sphere) else None
    return Surface(name, shape, Lambertian(albedo), AreaLight(radiance, zone))


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    channels = draw(st.integers(1, 5))
    names = draw(
        st.lists(st.text(st.characters(codec="utf-8"), min_size=1), min_size=1, max_size=4, unique=True)
    )
    lamp = draw(st.integers(0, len(names) - 1))
    parts = [draw(surfaces(name, channels, i == lamp or draw(st.booleans()))) for i, name in enumerate(names)]
    return Scene(tuple(parts), draw(sensors))


# ---- there and back


@pytest.mark.parametrize("name", CASES)
def test_every_case(name: str, tmp_path: Path) -> None:
    scene = case(name).scene
    content = scene.to_json()
    assert Scene.from_json(content) == Scene.from_json(content.decode()) == scene
    (tmp_path / "scene.json").write_bytes(content)
    assert Scene.load(tmp_path / "scene.json") == scene
    assert Scene.from_json(content).to_json() == content


@reproducible
@given(scenes())
def test_any_scene(scene: Scene) -> None:
    assert Scene.from_json(scene.to_json()) == scene


def test_numpy_numbers_are_numbers() -> None:
    light = AreaLight(np.array([1.0]), PolarRange(np.float32(0), np.float64(30)))
    ball = Surface("ball", Sphere(np.zeros(3), np.float64(2)), Lambertian(np.array([0.5])), light)
    scene = Scene([ball], Pinhole([0, 0, 5], np.zeros(3), [0, 1, 0], np.float64(30), 4, 4))
    assert Scene.from_json(scene.to_json()) == scene


# ---- nothing but a SceneError

numbers = st.integers() | st.floats(-1e60, 1e60) | st.just(float("nan")) | st.just(float("inf"))
json_values = st.recursive(
    st.none() | st.booleans() | numbers | st.text(),
    lambda children: st.lists(children, max_size=4) | st.dictionaries(st.text(), children, max_size=4),
    max_leaves=8,
)


def read(content: str) -> Scene | None:
    try:
        return Scene.from_json(content)
    except SceneError:
        return None


@reproducible
@given(json_values)
def test_any_json_is_refused(value: Any) -> None:
    assert read(json.dumps(value)) is None


def places(inner: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a document."""
    keys = list(inner) if isinstance(inner, dict) else range(len(inner)) if isinstance(inner, list) else []
    return [(inner, key) for key in keys] + [place for key in keys for place in places(inner[key])]


@settings(reproducible, max_examples=300)
@given(st.sampled_from(sorted(CASES)), st.data())
def test_one_wrong_field_makes_a_scene_or_a_refusal(name: str, data: st.DataObject) -> None:
    content = json.loads(case(name).scene.to_json())
    container, key = data.draw(st.sampled_from(places(content)))
    container[key] = data.draw(json_values)
    scene = read(json.dumps(content))
    assert scene is None or Scene.from_json(scene.to_json()) == scene
