"""Materials: how a surface reflects, the data of R."""

from __future__ import annotations

import msgspec

from scenes.validation import SceneError, numbers, path


class Lambertian(msgspec.Struct, frozen=True, tag_field="type", tag="lambertian", forbid_unknown_fields=True):
    """Reflects the same radiance into every direction: f_r = albedo / π (Lambert 1760).

    Attributes:
        albedo: reflectance per channel, each in [0, 1].
    """

    albedo: tuple[float, ...]

    def __post_init__(self) -> None:
        if not numbers(self, "albedo", low=0.0, high=1.0):
            raise SceneError(path(self, "albedo"), self.albedo, "one number per channel")


Material = Lambertian
