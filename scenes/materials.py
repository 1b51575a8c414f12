"""Materials: how a surface reflects, the data of R.

``albedo``, ``reflectance``, ``eta`` and ``k`` have one number per channel. A material without such a field, a
dielectric, goes with any number of channels.
"""

from __future__ import annotations

from typing import Literal, get_args

import msgspec
import numpy as np

from scenes.channels import check_channels
from scenes.images import Image
from scenes.validation import SceneError, instance, number, path, per_channel, positive, whole


class Checkerboard(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="checkerboard",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Two values in turn over squares of texture coordinates (u, v).

    Attributes:
        even, odd: per channel, in [0, 1]; ``even`` is the square that holds (0, 0).
        columns, rows: squares along u and along v.
    """

    even: tuple[float, ...]
    odd: tuple[float, ...]
    columns: int = 2
    rows: int = 2

    def __post_init__(self) -> None:
        even, odd = per_channel(self, "even", high=1.0), per_channel(self, "odd", high=1.0)
        if len(even) != len(odd):
            raise SceneError(path(self, "odd"), odd, f"{len(even)} channels, as even has")
        for field in ("columns", "rows"):
            if whole(self, field, "a whole number, at least 1") < 1:
                raise SceneError(path(self, field), getattr(self, field), "a whole number, at least 1")

    @property
    def channels(self) -> int:
        """Numbers per value."""
        return len(self.even)


class ImageTexture(
    msgspec.Struct, frozen=True, tag_field="type", tag="image", forbid_unknown_fields=True, omit_defaults=True
):
    """An image over texture coordinates: its top left corner is (0, 1), its bottom right one (1, 0).

    Attributes:
        image: values in [0, 1].
        interpolation: ``nearest``, or ``bilinear`` between the centres of pixels, held constant beyond the last.
    """

    image: Image
    interpolation: Literal["nearest", "bilinear"] = "bilinear"

    def __post_init__(self) -> None:
        instance(self, "image", Image, "an Image")
        values = self.image.array
        if values.max() > 1:
            row, column, channel = np.unravel_index(values.argmax(), values.shape)
            place = f"image.pixels[{row}][{column}][{channel}]"
            raise SceneError(path(self, place), float(values.max()), "a number in [0, 1]")
        instance(self, "interpolation", str, "nearest or bilinear")
        if self.interpolation not in ("nearest", "bilinear"):
            raise SceneError(path(self, "interpolation"), self.interpolation, "nearest or bilinear")

    @property
    def channels(self) -> int:
        """Numbers per value."""
        return self.image.channels


Texture = Checkerboard | ImageTexture
Shadowing = Literal["correlated", "separable"]


class Lambertian(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="lambertian",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Reflects the same radiance into every direction: f_r = albedo / π (Lambert 1760).

    Attributes:
        albedo: reflectance per channel, each in [0, 1], or a texture of such.
    """

    albedo: tuple[float, ...] | Texture

    def __post_init__(self) -> None:
        if not isinstance(self.albedo, Texture):
            per_channel(self, "albedo", high=1.0)

    @property
    def channels(self) -> int:
        """Channels of the albedo."""
        return self.albedo.channels if isinstance(self.albedo, Texture) else len(self.albedo)

    @property
    def textured(self) -> bool:
        """Whether the albedo depends on texture coordinates."""
        return isinstance(self.albedo, Texture)


class Mirror(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="mirror",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Reflects into the mirrored direction alone, at any angle the same share.

    Attributes:
        reflectance: per channel, each in [0, 1].
    """

    reflectance: tuple[float, ...]

    def __post_init__(self) -> None:
        per_channel(self, "reflectance", high=1.0)

    @property
    def channels(self) -> int:
        """Channels of the reflectance."""
        return len(self.reflectance)


class Dielectric(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="dielectric",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A smooth boundary between two clear media; reflects and refracts by Fresnel's equations.

    The front of the surface looks into the exterior. Radiance scales by (η / η′)² where it is refracted.

    Attributes:
        interior_ior: index of refraction behind the surface, > 0.
        exterior_ior: index of refraction in front of it, > 0. Where the two are the same there is no boundary, and
            crossing it would be no bounce: leave the surface out.
    """

    interior_ior: float = 1.5
    exterior_ior: float = 1.0

    def __post_init__(self) -> None:
        _two_media(self)

    channels = None


class Conductor(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="conductor",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A smooth metal; reflects by Fresnel's equations with the complex index η + ik relative to the outside.

    Attributes:
        eta: per channel, > 0.
        k: per channel, ≥ 0.
    """

    eta: tuple[float, ...]
    k: tuple[float, ...]

    def __post_init__(self) -> None:
        _complex_ior(self)

    @property
    def channels(self) -> int:
        """Channels of the index of refraction."""
        return len(self.eta)


class RoughConductor(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="rough_conductor",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A rough metal: GGX microfacets, single scattering (Walter et al. 2007).

    Attributes:
        eta, k: complex index of refraction per channel, as of a conductor.
        alpha: roughness, in [0.001, 1].
        shadowing: Smith's, ``correlated`` by the height of facets (pbrt) or ``separable`` (Walter; Mitsuba).
    """

    eta: tuple[float, ...]
    k: tuple[float, ...]
    alpha: float
    shadowing: Shadowing = "correlated"

    def __post_init__(self) -> None:
        _complex_ior(self)
        _roughness(self)

    @property
    def channels(self) -> int:
        """Channels of the index of refraction."""
        return len(self.eta)


class RoughDielectric(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="rough_dielectric",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A rough boundary between two clear media: GGX microfacets, single scattering (Walter et al. 2007).

    Attributes:
        alpha: roughness, in [0.001, 1].
        interior_ior, exterior_ior: as of a dielectric.
        shadowing: as of a rough metal; the same for refraction.
    """

    alpha: float
    interior_ior: float = 1.5
    exterior_ior: float = 1.0
    shadowing: Shadowing = "correlated"

    def __post_init__(self) -> None:
        _roughness(self)
        _two_media(self)

    channels = None


class Blend(
    msgspec.Struct, frozen=True, tag_field="type", tag="blend", forbid_unknown_fields=True, omit_defaults=True
):
    """A mixture: (1 − weight) · first + weight · second.

    Attributes:
        first, second: materials, blends too.
        weight: in [0, 1].
    """

    first: Material
    second: Material
    weight: float

    def __post_init__(self) -> None:
        instance(self, "first", Material, "a material")
        instance(self, "second", Material, "a material")
        if not 0 <= number(self, "weight", "a number in [0, 1]") <= 1:
            raise SceneError(path(self, "weight"), self.weight, "a number in [0, 1]")
        check_channels([(path(self, "first"), self.first), (path(self, "second"), self.second)])

    @property
    def channels(self) -> int | None:
        """Channels of the two; None if both go with any number."""
        return self.first.channels if self.first.channels is not None else self.second.channels


Material = Lambertian | Mirror | Dielectric | Conductor | RoughConductor | RoughDielectric | Blend


def has_dielectric(material: Material) -> bool:
    """Whether the material, or a part of it, lets light through."""
    if isinstance(material, Blend):
        return has_dielectric(material.first) or has_dielectric(material.second)
    return isinstance(material, Dielectric | RoughDielectric)


def is_textured(material: Material) -> bool:
    """Whether the material depends on texture coordinates anywhere."""
    if isinstance(material, Blend):
        return is_textured(material.first) or is_textured(material.second)
    return isinstance(material, Lambertian) and material.textured


def _roughness(owner: RoughConductor | RoughDielectric) -> None:
    expected = "a roughness in [0.001, 1]; below that use the smooth material"
    if not 0.001 <= number(owner, "alpha", expected) <= 1:
        raise SceneError(path(owner, "alpha"), owner.alpha, expected)
    if owner.shadowing not in get_args(Shadowing):
        raise SceneError(path(owner, "shadowing"), owner.shadowing, "correlated or separable")


def _two_media(owner: Dielectric | RoughDielectric) -> None:
    positive(owner, "interior_ior", "exterior_ior")
    if owner.interior_ior == owner.exterior_ior:
        expected = "another index than exterior_ior: without refraction there is no boundary, leave it out"
        raise SceneError(path(owner, "interior_ior"), owner.interior_ior, expected)


def _complex_ior(owner: Conductor | RoughConductor) -> None:
    eta, k = per_channel(owner, "eta"), per_channel(owner, "k")
    if min(eta) <= 0:
        raise SceneError(path(owner, f"eta[{eta.index(min(eta))}]"), min(eta), "a number > 0")
    if len(k) != len(eta):
        raise SceneError(path(owner, "k"), k, f"{len(eta)} channels, as eta has")
