"""Which texel is where: a board printed with an image, under a directional light.

Everything that reflects lies in one plane, so that E = 0, TE = (ρ/π) E cos θ with the albedo ρ of the place, T²E = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images
from scenes.images import Image
from scenes.library.direct_light import TOLERANCE
from scenes.lights import DirectionalLight
from scenes.materials import ImageTexture, Lambertian
from scenes.pixels_on_rectangle import pixels_on
from scenes.scene import Scene
from scenes.sensor import Orthographic
from scenes.shapes import Quad
from scenes.surfaces import Surface

Array = NDArray[np.float64]


def _printed(scene: Scene, bounces: int) -> Images:
    """TE = (E cos θ / π) × the mean albedo of the pixel: texels by the area of them that it covers."""
    [board], [light] = scene.surfaces, scene.lights
    assert isinstance(board.shape, Quad)
    assert isinstance(board.material, Lambertian)
    assert isinstance(board.material.albedo, ImageTexture)
    assert isinstance(scene.sensor, Orthographic)
    assert isinstance(light, DirectionalLight)
    texels = board.material.albedo.image.array[::-1].swapaxes(0, 1)  # by u, then v, which grows upwards
    pixels = pixels_on(board.shape, scene.sensor)
    u, v = np.array(board.shape.edge_u), np.array(board.shape.edge_v)
    along_u = abs(pixels.frame[0] @ u) > abs(pixels.frame[0] @ v)
    grid_u, grid_v = (pixels.columns, pixels.rows) if along_u else (pixels.rows, pixels.columns)
    in_u, in_v = (
        _overlaps(ends, float(np.linalg.norm(edge)), count)
        for ends, edge, count in ((grid_u, u, texels.shape[0]), (grid_v, v, texels.shape[1]))
    )
    albedo = np.einsum("iu,uvc,jv->jic" if along_u else "iu,uvc,jv->ijc", in_u, texels, in_v) / pixels.area
    images = np.zeros((bounces + 1, *scene.shape))
    if bounces:
        cosine = -(board.shape.normal @ light.direction) / np.linalg.norm(light.direction)
        images[1] = albedo * np.array(light.irradiance) * cosine / np.pi
    return images


def _overlaps(ends: Array, length: float, texels: int) -> Array:
    """How much of each pixel lies in each of so many equal parts of a length, ``(pixels, texels)``."""
    parts = np.linspace(0.0, length, texels + 1)
    low, high = np.sort([ends[:-1], ends[1:]], axis=0)[..., None]
    overlaps: Array = np.maximum(np.minimum(high, parts[1:]) - np.maximum(low, parts[:-1]), 0.0)
    return overlaps


def printed_board() -> Case:
    """Five by three texels, no two of them alike."""
    rows = tuple(
        tuple((0.9 - 0.15 * i, 0.2 + 0.3 * j, 0.1 + 0.1 * (i + 2 * j) % 0.8) for i in range(5))
        for j in range(3)
    )
    texture = ImageTexture(Image(rows), "nearest")
    board = Quad((-1.1, 0.0, 1.0), (2.2, 0.0, 0.0), (0.0, 0.0, -2.0))
    return Case(
        name="printed-board",
        family="textures",
        title="A board printed with fifteen texels under a directional light: TE = ρ E cos θ / π, texel by texel",
        scene=Scene(
            (Surface("board", board, Lambertian(texture)),),
            Orthographic((0.1, 2.0, 0.9), (0.1, 0.0, 0.0), (0.0, 0.0, -1.0), 1.8, 64, 64),
            (DirectionalLight((0.5, -1.0, 0.3), (3.0, 4.0, 5.0)),),
        ),
        answer=Formula(_printed, "Lambert 1760, Photometria"),
        bounces=2,
        tolerance=TOLERANCE,
        derivation="""\
A texel that is not interpolated is a rectangle of one albedo. Parallel rays carry the pixels to the board as
rectangles too, whose sides run along its own, so that a pixel's mean albedo is that of the texels it covers, weighted
by the area of each that lies in it. All of the board has the same irradiance E cos θ, and nothing lights it but that:
E = 0, TE = ρ E cos θ / π, T²E = 0. The image's top left corner is at (u, v) = (0, 1): the first row of texels lies
where v is largest.""",
        blind_to="textures that are interpolated, and coordinates on anything but a rectangle",
    )


CASES: Mapping[str, Callable[[], Case]] = {"printed-board": printed_board}
