"""A case: a scene, its answer bounce by bounce, and what it can and can't reveal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Literal

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


@dataclass(frozen=True)
class Formula:
    """An exact answer.

    Attributes:
        evaluate: (scene, bounces) → ``(bounces + 1, height, width, channels)``.
        source: where the formula comes from.
    """

    evaluate: Callable[[Scene, int], Images]
    source: str
    kind: TruthKind = "exact"

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

    def truth(self, scene: Scene, bounces: int) -> Truth | None:
        """The committed data, averaged over blocks of pixels to the scene's resolution.

        Returns:
            None if there is no such data: too many bounces, or a resolution that does not divide the data's.
        """
        mean, stderr = exr.read_bounces(self.path)
        height, width, _ = scene.shape
        rows, columns = mean.shape[1] // height, mean.shape[2] // width
        if (
            bounces >= len(mean)
            or (rows * height, columns * width) != mean.shape[1:3]
            or rows != columns
            or not rows
        ):
            return None
        blocks = (bounces + 1, height, rows, width, columns, -1)
        # a coarse pixel is the mean of the fine ones inside it: exact, since the filter is a box
        variance = (stderr[: bounces + 1] ** 2).reshape(blocks).sum(axis=(2, 4)) / (rows * columns) ** 2
        return Truth(mean[: bounces + 1].reshape(blocks).mean(axis=(2, 4)), np.sqrt(variance), self.source)


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
