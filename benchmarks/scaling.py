"""Nanoseconds per path as a function of one thing at a time: shapes, spp, bounces, channels, strategy.

The base is the Cornell box, 64×64, 16 spp, bounces 0 to 5, 3 channels, strategy mis, independent numbers. For
shapes it is the empty box with a cloud of them in its middle: a sphere of triangles, or separate quads or spheres.
A path is a walk from the sensor with all its bounces and shadow rays. What a scene costs before its first path, the
set-up, is timed in turn with the renders, shown by itself and subtracted. There is one side only, so CPU time is
taken, which hardly sees what else the machine does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import msgspec
import numpy as np
from rich.table import Table

from benchmarks.timing import Progress, interleaved
from reference_tracer.random_walk import RandomWalk, render
from scenes import AreaLight, Lambertian, Mesh, Quad, Scene, Sphere, Surface
from scenes.library.cornell_box import cornell_box, empty_box
from scenes.shapes import Shape

SPP, BOUNCES, REPETITIONS = 16, 5, 5
SPPS, QUICK_SPPS = (1, 4, 16, 64, 256), (1, 2)
BOUNCE_COUNTS, QUICK_BOUNCE_COUNTS = (0, 1, 2, 5, 10, 20), (0, 1)
CHANNELS, QUICK_CHANNELS = (1, 3, 16, 64), (1, 3)
COUNTS = {"triangles": (1, 10, 100, 1000, 5000), "quads": (1, 10, 100, 500), "spheres": (1, 10, 100, 200)}
QUICK_COUNTS = {"triangles": (1, 30), "quads": (1,), "spheres": (1,)}

_GREY = Lambertian((0.7, 0.7, 0.7))


class Cost(msgspec.Struct, frozen=True):
    """A measured cost.

    Attributes:
        over: what is varied.
        value: its value.
        nanoseconds: per path, the median, without the set-up.
        low, high: of the repetitions.
        set_up: milliseconds before the first path, the median.
    """

    over: str
    value: str
    nanoseconds: float
    low: float
    high: float
    set_up: float


def measure(quick: bool, progress: Progress) -> list[Cost]:
    """All of them; those of a family are timed in turn."""
    costs = []
    for over, renders in _families(quick):
        progress(over)
        sides = {}
        for value, arguments in renders.items():
            sides[value] = partial(_render, arguments)
            sides[f"set-up {value}"] = partial(_set_up, arguments)
        seconds = interleaved(sides, 2 if quick else REPETITIONS, clock="cpu")
        for value, arguments in renders.items():
            height, width, _ = arguments["scene"].shape
            set_up = float(np.median(seconds[f"set-up {value}"]))
            each = 1e9 / (height * width * arguments["spp"]) * (seconds[value] - set_up)
            low, high = float(each.min()), float(each.max())
            costs.append(Cost(over, value, float(np.median(each)), low, high, 1e3 * set_up))
    return costs


def _render(arguments: dict[str, Any], seed: int) -> None:
    render(**arguments, seed=seed)


def _set_up(arguments: dict[str, Any], seed: int) -> None:
    RandomWalk(arguments["scene"], arguments.get("strategy", "mis"))


def table(costs: list[Cost]) -> Table:
    """To read."""
    result = Table(caption="CPU time; lowest–highest of the repetitions")
    result.add_column("over")
    for column in ("value", "ns per path", "lowest–highest", "set-up, ms"):
        result.add_column(column, justify="right")
    for i, cost in enumerate(costs):
        if i and costs[i - 1].over != cost.over:
            result.add_section()
        result.add_row(
            cost.over,
            cost.value,
            f"{cost.nanoseconds:,.0f}",
            f"{cost.low:,.0f}–{cost.high:,.0f}",
            f"{cost.set_up:,.1f}",
        )
    return result


def as_json(costs: list[Cost]) -> bytes:
    """For programs."""
    return msgspec.json.format(msgspec.json.encode(costs), indent=2)


def _families(quick: bool) -> Iterator[tuple[str, dict[str, dict[str, Any]]]]:
    """What is varied, and the arguments of each render."""
    base: dict[str, Any] = {"scene": cornell_box().scene, "bounces": BOUNCES, "spp": SPP}
    for kind, counts in (QUICK_COUNTS if quick else COUNTS).items():
        yield kind, {f"{count:,}": base | {"scene": with_shapes(kind, count)} for count in counts}
    yield "spp", {str(spp): base | {"spp": spp} for spp in (QUICK_SPPS if quick else SPPS)}
    bounces = QUICK_BOUNCE_COUNTS if quick else BOUNCE_COUNTS
    yield "bounces", {str(count): base | {"bounces": count} for count in bounces}
    channels = QUICK_CHANNELS if quick else CHANNELS
    yield "channels", {str(count): base | {"scene": with_channels(count)} for count in channels}
    yield "strategy", {name: base | {"strategy": name} for name in ("bsdf", "nee", "mis")}
    yield "sampler", {name: base | {"sampler": name} for name in ("independent", "sobol")}


def with_channels(count: int) -> Scene:
    """The Cornell box in grey, with so many channels."""
    scene = cornell_box().scene
    surfaces = [
        msgspec.structs.replace(
            surface,
            material=Lambertian((0.5,) * count),
            emission=AreaLight((10.0,) * count) if surface.emission else None,
        )
        for surface in scene.surfaces
    ]
    return msgspec.structs.replace(scene, surfaces=tuple(surfaces))


def with_shapes(kind: str, count: int) -> Scene:
    """The empty box with so many triangles of one mesh, quads or spheres in its middle."""
    if kind == "triangles":
        added = [Surface("cloud", ball(count), _GREY)]
    else:
        shapes = quads(count) if kind == "quads" else spheres(count)
        added = [Surface(f"cloud-{i}", shape, _GREY) for i, shape in enumerate(shapes)]
    scene = empty_box()
    return msgspec.structs.replace(scene, surfaces=(*scene.surfaces, *added))


def ball(triangles: int) -> Mesh:
    """A sphere of radius ½ of so many triangles: a grid of longitudes and latitudes, poles cut off."""
    rows = max(1, math.isqrt(triangles // 4))
    columns = -(-triangles // (2 * rows))
    theta, phi = np.linspace(0.2, np.pi - 0.2, rows + 1), np.linspace(0, 2 * np.pi * 0.99, columns + 1)
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    vertices = 0.5 * np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], axis=1)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    halves = np.stack(
        [[first, first + 1, first + columns + 2], [first, first + columns + 2, first + columns + 1]]
    )
    chosen = halves.transpose(2, 0, 1).reshape(-1, 3)[:triangles]
    return Mesh(tuple(map(tuple, vertices.tolist())), tuple(map(tuple, chosen.tolist())))


def quads(count: int) -> list[Shape]:
    """Squares that lie in no common frame, each in a cell of its own."""
    rng, shapes = np.random.default_rng(0), list[Shape]()
    for center, radius in zip(*_cells(count), strict=True):
        u, v = np.linalg.qr(rng.normal(size=(3, 2)))[0].T * radius
        corner, edges = center - u / 2 - v / 2, (u, v)
        shapes.append(Quad(tuple(corner.tolist()), *(tuple(edge.tolist()) for edge in edges)))
    return shapes


def spheres(count: int) -> list[Shape]:
    """Spheres, each in a cell of its own."""
    return [Sphere(tuple(c.tolist()), float(r)) for c, r in zip(*_cells(count), strict=True)]


def _cells(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the cells of a grid over the middle of the box, and the radius of a ball that fits in."""
    side = next(n for n in range(1, count + 1) if n**3 >= count)
    along = (np.arange(side) + 0.5) / side * 1.2 - 0.6
    centers = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1).reshape(-1, 3)[:count]
    return centers, np.full(count, 0.4 * 1.2 / side)
