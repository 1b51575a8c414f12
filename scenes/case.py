"""A case: a scene, its answer bounce by bounce, and what it can and can't reveal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from scenes.channels import check_wavelengths
from scenes.formats import exr
from scenes.scene import Scene

Images = NDArray[np.float64]
TruthKind = Literal["exact", "computed", "estimated"]


@dataclass(frozen=True)
class Truth:
    """The answer.

    Attributes:
        mean: TᵏE as the sensor sees it, each pixel's average, ``(bounces + 1, height, width, channels)``.
        stderr: standard error of each pixel, of the same shape; 0 where the answer has no noise.
        source: where it comes from: a formula's source, or how an estimate was made.
    """

    mean: Images
    stderr: Images
    source: str

    @property
    def bounces(self) -> int:
        """The last bounce."""
        return len(self.mean) - 1


@dataclass(frozen=True)
class Tolerance:
    """How large a relative bias may be, per bounce; beyond the last entry the last one holds."""

    image: tuple[float, ...]
    tile: tuple[float, ...]

    def of_image(self, bounce: int) -> float:
        """For the mean of the whole image."""
        return self.image[min(bounce, len(self.image) - 1)]

    def of_tile(self, bounce: int) -> float:
        """For the mean of a tile."""
        return self.tile[min(bounce, len(self.tile) - 1)]

    def of_sum(self, means: Sequence[float] | np.ndarray[Any, Any]) -> Tolerance:
        """What a sum of bounces would use up if every bounce used its own: Σ tolerance_k · mean_k / Σ mean_k.

        Args:
            means: of each bounce, over the whole image.
        """
        weights = np.asarray(means, dtype=float)
        weights = weights / weights.sum() if weights.sum() > 0 else np.full(len(weights), 1 / len(weights))
        image = sum(float(w) * self.of_image(k) for k, w in enumerate(weights))
        tile = sum(float(w) * self.of_tile(k) for k, w in enumerate(weights))
        return Tolerance(image=(image,), tile=(tile,))


@dataclass(frozen=True)
class Formula:
    """An exact answer.

    Attributes:
        evaluate: (scene, bounces) → ``(bounces + 1, height, width, channels)``.
        source: where the formula comes from.
        total: scene → the sum of all bounces, ``(height, width, channels)``, where it has a formula of its own that
            takes less work than its terms.
    """

    evaluate: Callable[[Scene, int], Images]
    source: str
    kind: TruthKind = "exact"
    total: Callable[[Scene], Images] | None = None

    def truth(self, scene: Scene, bounces: int) -> Truth:
        """The answer for the resolution of the scene's sensor."""
        mean = self.evaluate(scene, bounces)
        return Truth(mean, np.zeros_like(mean), self.source)


@dataclass(frozen=True)
class Committed:
    """An answer that was made once and is committed data.

    Attributes:
        file: an EXR file of bounce images beside the library, or anywhere, by its absolute path.
    """

    file: str

    @property
    def path(self) -> Path:
        """Where the data lies."""
        return Path(str(files("scenes.library") / "data" / self.file))

    @property
    def source(self) -> str:
        """How the data was made, as its header says."""
        return exr.read_attribute(self.path, "lightproof:source")

    @property
    def path_of_later(self) -> Path:
        """Where the sum of all bounces after those of the data lies, an image of its own, if there is one."""
        return self.path.with_name(f"{self.path.stem}-later.exr")

    def truth(self, scene: Scene, bounces: int) -> Truth | None:
        """The committed data, averaged over blocks of pixels to the scene's resolution.

        Returns:
            None if there is no such data: too many bounces, or a resolution that does not divide the data's.
        """
        found = self.all_bounces(scene)
        if found is None or bounces > found.bounces:
            return None
        return Truth(found.mean[: bounces + 1], found.stderr[: bounces + 1], found.source)

    def all_bounces(self, scene: Scene) -> Truth | None:
        """All bounces that the data has, averaged to the scene's resolution; None as of ``truth``."""
        images = _averaged(*exr.read_bounces(self.path), scene)
        return Truth(*images, self.source) if images else None

    def later(self, scene: Scene) -> Truth | None:
        """The sum of all bounces after those, as one image; None if it was not made, or as of ``truth``."""
        if not self.path_of_later.exists():
            return None
        images = _averaged(*exr.read_bounces(self.path_of_later), scene)
        return Truth(*images, exr.read_attribute(self.path_of_later, "lightproof:source")) if images else None


def _averaged(mean: Images, stderr: Images, scene: Scene) -> tuple[Images, Images] | None:
    """Means over blocks of pixels, with their errors; None at a resolution that does not divide that of the data."""
    height, width, _ = scene.shape
    rows, columns = mean.shape[1] // height, mean.shape[2] // width
    if (rows * height, columns * width) != mean.shape[1:3] or rows != columns or not rows:
        return None
    blocks = (len(mean), height, rows, width, columns, -1)
    # a coarse pixel is the mean of the fine ones inside it: exact, since the filter is a box
    variance = (stderr**2).reshape(blocks).sum(axis=(2, 4)) / (rows * columns) ** 2
    return mean.reshape(blocks).mean(axis=(2, 4)), np.sqrt(variance)


@dataclass(frozen=True)
class Estimate(Committed):
    """An answer that a Monte Carlo estimator made, with its standard error."""

    kind: TruthKind = "estimated"


@dataclass(frozen=True)
class Computed(Committed):
    """An answer that finite elements made: no noise, but an error, which a finer mesh tells.

    Attributes:
        order, levels, splits: of the coarser of two meshes: nodes per patch and axis, grading towards edges, and
            further mesh lines (surface name → values of s along edge_u, of t along edge_v); None: the solver's own.
    """

    order: int | None = None
    levels: int | None = None
    splits: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None
    kind: TruthKind = "computed"

    @property
    def error(self) -> tuple[float, ...]:
        """Per bounce, how far the coarser mesh is off: root mean square of pixels over the mean of the image."""
        return tuple(float(text) for text in exr.read_attribute(self.path, "lightproof:error").split())


@dataclass(frozen=True)
class Case:
    """A scene whose every bounce is known.

    Attributes:
        name: as on the command line.
        family: the file of the library that it stands in.
        title: one line.
        scene: at its default resolution.
        answer: a formula, or what finite elements or an estimator made.
        bounces: how many bounces a validation asks for unless told otherwise.
        max_bounces: the last bounce that the answer holds for; None for no limit.
        tolerance: relative.
        derivation: why the answer is what it is.
        blind_to: what the case can't reveal.
        tiles: rows and columns of the grid of tiles.
        wavelengths: of each channel, nm, ascending in equal steps within 360 to 830; None where channels are red,
            green and blue, or just numbers.

    Raises:
        ValueError: the wavelengths are not those of the scene's channels.
    """

    name: str
    family: str
    title: str
    scene: Scene
    answer: Formula | Computed | Estimate
    bounces: int
    tolerance: Tolerance
    derivation: str
    blind_to: str
    max_bounces: int | None = None
    tiles: tuple[int, int] = field(default=(4, 4))
    wavelengths: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.wavelengths is not None:
            check_wavelengths(self.wavelengths, self.scene.channels)
