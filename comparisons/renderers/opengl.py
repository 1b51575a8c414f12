"""pyrender: OpenGL as a witness for E and G. It draws what is visible, and shares nothing with any path tracer.

First hits come from its depth buffer and its segmentation, which has a colour for each side of each surface: OpenGL
itself tells front from back, by culling. It has no normals. pyrender asks for four samples per pixel, none of them in
its middle; for a segmentation it switches them off, and both buffers then hold what is in the middle.

Bounce 0 is what the visible sides emit, averaged over points of the pixel: 8 × 8 pixels for one, drawn 64 times with
the points moved about, so that 512 columns and 512 rows of points cross each pixel. An edge along a row or a column
is misplaced by 1/1024 of a pixel at most; at the worst angle, half a right one, the share of a pixel that is covered
is off by 0.8 %. Scenes of many triangles, as spheres need them, are drawn 16 times: 1/256 of a pixel, and 1.6 %.
An image of more than 512 pixels across has fewer than 8 × 8 for one. There are no random numbers: whatever spp and
seed are, the image is the same.

A depth buffer of 24 bits can't hold the near and the far as well: the scene is drawn in up to four ranges of
distance, each 16 times as far as the one before, down to 2⁻¹⁶ of the farthest. What is nearer than that is not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.opengl_platform import canvas, load
from comparisons.renderers.opengl_triangles import triangles
from comparisons.renderers.opengl_view import View
from comparisons.renderers.protocol import Hits, Images, RendererFailed, Unsupported
from scenes import ConstantEnvironment, RadianceMeter, Scene, ThinLens
from scenes.bounds import farthest
from scenes.features import features

Array = NDArray[np.float64]
Labels = NDArray[np.intp]

_RANGES, _RATIO = 4, 16.0
_OVERLAP = 1.001  # of one range and the next, so that nothing falls between them
_FINER, _SHIFTS, _FEWER_SHIFTS = 8, 64, 16
_MANY = 50_000
"""Triangles, both sides counted."""
_LARGEST = 4096
"""Pixels across; what OpenGL has to be able to draw at once."""

_NOTHING = 0
"""The label of pixels that see no surface; those of surface i are 1 + 2i for its front and 2 + 2i for its back."""


def supports() -> dict[str, Sequence[str]]:
    """What it can witness, in the words of ``scenes.features``; every material, since none reflects in bounce 0."""
    return {
        "shapes": ("quad", "disk", "sphere", "ellipsoid", "mesh", "inward", "shading normals", "two_sided"),
        "materials": ("any",),
        "lights": ("area", "point", "spot", "directional", "constant"),
        "sensors": ("pinhole", "orthographic", "radiance_meter"),
        "images": ("bounce 0", "first hits"),
        "seed": ("no noise",),
    }


class PyrenderRenderer:
    """OpenGL through pyrender, drawn without a screen."""

    def __init__(self, _: str = "") -> None:
        self._pyrender = load()
        self._canvas = canvas(self._pyrender)
        self._E = lru_cache(maxsize=8)(self._emission)  # asked again and again: it has no noise

    def version(self) -> str:
        """Of pyrender."""
        return str(self._pyrender.__version__)

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """E, what is visible and emits; see the protocol.

        Raises:
            Unsupported: any later bounce; what changes within a surface or over the lens.
        """
        for k in bounces:
            if k > 0:
                raise Unsupported(
                    f"bounce {k}: the OpenGL witness sees what is emitted, nothing that is reflected"
                )
        _refuse_what_labels_cannot_tell(scene)
        return np.repeat(self._E(scene)[None], len(bounces), axis=0)

    def first_hits(self, scene: Scene) -> Hits:
        """The depth buffer and the segmentation; see the protocol. Normals are (0, 0, 0), which says nothing."""
        view = View.of(scene.sensor)
        label, depth = self._stage(scene, view).draw(view)
        distance = (depth * view.per_view()).ravel()
        surface = (label.ravel() - 1) // 2  # −1 for nothing
        return np.array([distance, *np.zeros((3, distance.size)), surface], dtype=np.float64)

    def _emission(self, scene: Scene) -> Array:
        view = View.of(scene.sensor)
        radiances, of_label = np.unique(_Le(scene), axis=0, return_inverse=True)
        stage, mean = self._stage(scene, view), np.zeros(scene.shape)
        finer, shifts = min(_FINER, max(1, _LARGEST // max(view.width, view.height))), _SHIFTS
        if isinstance(scene.sensor, RadianceMeter):
            finer, shifts = 1, 1  # its pixel is one ray
        elif stage.triangles >= _MANY:
            shifts = _FEWER_SHIFTS
        for shift in _shifts(shifts):
            label, _ = stage.draw(view.finer(finer), shift)
            seen = of_label.reshape(-1)[label].reshape(view.height, finer, view.width, finer)
            for i in np.flatnonzero(radiances.any(axis=1)):
                mean += (seen == i).mean(axis=(1, 3))[..., None] * radiances[i] / shifts
        return mean

    def _stage(self, scene: Scene, view: View) -> _Stage:
        return _Stage(self._pyrender, self._canvas, scene, view)


class Drawn(NamedTuple):
    """What each pixel sees, ``(height, width)``: a label; how far along the view, world units, inf for nothing."""

    label: Labels
    along: Array


class _Stage:
    """A scene in pyrender's world: each side of each surface with a colour of its own."""

    def __init__(self, pyrender: Any, canvas: Any, scene: Scene, view: View) -> None:
        self._pyrender, self._canvas = pyrender, canvas
        self._scale = 1 / (farthest(scene) or 1.0)
        self._made, self._colours = pyrender.Scene(), dict[Any, tuple[int, ...]]()
        self.triangles, self._last_label = 0, 2 * len(scene.surfaces)
        for i, surface in enumerate(scene.surfaces):
            corners, front = triangles(surface, view)
            self.triangles += 2 * len(front)
            positions = self._scale * (corners - view.origin)
            # of the segmentation pyrender culls all backs, so that a back is drawn as the front of the same
            # triangles the other way round
            for label, indices in ((1 + 2 * i, front), (2 + 2 * i, front[:, ::-1])):
                mesh = pyrender.Mesh([pyrender.Primitive(positions, indices=np.ascontiguousarray(indices))])
                self._colours[self._made.add(mesh)] = tuple(label.to_bytes(3, "big"))

    def draw(self, view: View, shift: tuple[float, float] = (0.0, 0.0)) -> Drawn:
        """What is seen through one point of each pixel: its middle, moved by the shift."""
        label = np.full((view.height, view.width), _NOTHING)
        along = np.full(label.shape, np.inf)
        for near, far in self._ranges():
            there = label == _NOTHING
            if not there.any() or not self._colours:
                break
            seen, depth = self._range(view, near, far, shift)
            new = there & (seen != _NOTHING)
            label[new] = seen[new]
            along[new] = view.along_the_view(depth[new], near, far) / self._scale
        return Drawn(label, along)

    def _ranges(self) -> Iterator[tuple[float, float]]:
        """The nearest first: what is seen in it hides the others."""
        for k in reversed(range(_RANGES)):
            yield _RATIO ** -(k + 1), _RATIO**-k * _OVERLAP

    def _range(self, view: View, near: float, far: float, shift: tuple[float, float]) -> tuple[Labels, Array]:
        if max(view.width, view.height) > _LARGEST:
            raise Unsupported(f"an image of more than {_LARGEST} pixels across")
        self._canvas.viewport_width, self._canvas.viewport_height = view.width, view.height
        camera = self._made.add(
            view.camera(self._pyrender, near, far, self._scale, shift), pose=view.pose(self._scale, shift)
        )
        self._made.main_camera_node = camera
        try:
            colour, depth = self._canvas.render(self._made, self._pyrender.RenderFlags.SEG, self._colours)
        finally:
            self._made.remove_node(camera)
        label = colour.astype(np.intp) @ (1 << 16, 1 << 8, 1)
        if label.max() > self._last_label:
            raise RendererFailed(f"a colour that was given to nothing: {label.max()} in its segmentation")
        return label, depth.astype(np.float64)


def _shifts(count: int) -> Iterator[tuple[float, float]]:
    """Points of the square around 0, of which each has a column and a row of its own (Hammersley's).

    Args:
        count: a power of two.
    """
    bits = count.bit_length() - 1
    for i in range(count):
        reversed_bits = sum(((i >> b) & 1) << (bits - 1 - b) for b in range(bits))
        yield (i + 0.5) / count - 0.5, (reversed_bits + 0.5) / count - 0.5


def _Le(scene: Scene) -> Array:
    """What is emitted where each label is seen, ``(labels, channels)``."""
    Le = np.zeros((1 + 2 * len(scene.surfaces), scene.channels))
    if isinstance(scene.environment, ConstantEnvironment):
        Le[_NOTHING] = scene.environment.radiance
    for i, surface in enumerate(scene.surfaces):
        if surface.emission is not None:
            Le[1 + 2 * i] = surface.emission.radiance
            Le[2 + 2 * i] = np.multiply(surface.emission.radiance, surface.two_sided)
    return Le


def _refuse_what_labels_cannot_tell(scene: Scene) -> None:
    """Refuse radiance that is not the same wherever the same side of a surface is seen.

    Raises:
        Unsupported: naming the feature.
    """
    if isinstance(scene.sensor, ThinLens):
        raise Unsupported("thin_lens sensor: its pixels see around the middle of the lens as well")
    beyond = {"polar_range", "angular_profile", "environment_map", "spherical_harmonics"}
    if missing := sorted(beyond & set(features(scene))):
        raise Unsupported(
            f"{', '.join(missing)}: the OpenGL witness sees surfaces, not where on one or at which angle"
        )
