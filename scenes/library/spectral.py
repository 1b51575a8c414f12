"""Spectral cases: a channel per wavelength, many of them, to be taken to XYZ and RGB by ``scenes.spectral``.

A renderer that carries colour as three numbers can't express them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec
import numpy as np

from scenes.case import Case, Computed, Formula, Tolerance
from scenes.library import cornell_spectra
from scenes.library.cornell_box import cornell_box, empty_box
from scenes.library.furnace import uniform_field
from scenes.lights import AreaLight
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.surfaces import Surface, box

_CORNELL = tuple(
    float(nm) for nm in range(404, 701, 8)
)  # every second measurement; at 400 nm the lamp is dark
_VISIBLE = tuple(float(nm) for nm in range(380, 781, 10))

_FURNACE = """\
A furnace per wavelength: every surface of a closed scene emits e(λ) and reflects the same albedo ρ at every
wavelength, so TᵏE = e(λ) ρᵏ. A factor that is the same for all wavelengths changes no chromaticity: every bounce has
that of the illuminant, which is tabulated by the CIE."""


def cornell_box_spectral() -> Case:
    """The empty Cornell box in its measured spectra."""
    image = (0.005, 0.005, 0.01, 0.02)
    return Case(
        name="cornell-box-spectral",
        family="spectral",
        title="The empty Cornell box in its measured spectra, 38 wavelengths from 404 to 700 nm",
        scene=_in_measured_spectra(empty_box()).resized(16, 16),
        answer=Computed("cornell-box-spectral.exr"),
        bounces=5,
        tolerance=Tolerance(image=image, tile=tuple(5 * t for t in image)),
        derivation=(
            "The empty Cornell box with the reflectances that Cornell University measured and the lamp's published "
            "spectrum, linear between its four values. T = ρ(λ) F: the form factors F are geometry and the same for "
            "all wavelengths, so finite elements compute one operator F and apply it at every wavelength with that "
            "wavelength's albedos. Every second measurement is taken, from 404 nm on (at 400 nm the lamp is dark).\n"
            "The reference tracer is not held to ±0.2 % at every bounce, since few paths carry the later ones: of "
            "the mean of the image half a million of them resolve 0.2, 1, 2, 4 and 5 % of TE to T⁵E."
        ),
        blind_to="visibility: no surface hides another; wavelengths that influence one another, as in fluorescence",
        wavelengths=_CORNELL,
    )


def _in_measured_spectra(scene: Scene) -> Scene:
    """The same scene, its walls and its lamp in their spectra instead of RGB."""
    known = {s.name: s.material for s in cornell_box().scene.surfaces}
    color = {known["floor"]: "white", known["green-wall"]: "green", known["red-wall"]: "red"}
    spectra = {m: _lambertian(cornell_spectra.reflectance(name, _CORNELL)) for m, name in color.items()}
    lamp = AreaLight(tuple(cornell_spectra.emission(_CORNELL).tolist()))
    surfaces: list[Surface] = [
        msgspec.structs.replace(s, material=spectra[s.material], emission=lamp if s.emission else None)
        for s in scene.surfaces
    ]
    return Scene(tuple(surfaces), scene.sensor)


def _lambertian(albedo: np.ndarray) -> Lambertian:
    return Lambertian(tuple(albedo.tolist()))


def furnace_equal_energy() -> Case:
    """A room that emits the same at every wavelength: chromaticity (1/3, 1/3) in every bounce."""
    e = np.ones(len(_VISIBLE))
    return _furnace("furnace-equal-energy", "equal energy (illuminant E): chromaticity (1/3, 1/3)", e, 0.5)


def furnace_d65() -> Case:
    """A room that emits daylight of 6500 K: its chromaticity in every bounce."""
    from scenes.spectral import illuminant  # takes a third of a second, and only this case needs it

    return _furnace(
        "furnace-d65", "daylight D65: chromaticity (0.3127, 0.3290)", illuminant("D65", _VISIBLE), 0.7
    )


def _furnace(name: str, light: str, e: np.ndarray, rho: float) -> Case:
    """A closed room 3 × 2 × 2.4, of one albedo, in that light."""
    walls = box(
        "room",
        (0.0, 0.0, 0.0),
        ((1.5, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.2)),
        _lambertian(np.full(len(e), rho)),
        inward=True,
        emission=AreaLight(tuple(e.tolist())),
    )
    sensor = Pinhole((0.9, -0.3, 0.8), (-0.6, 0.2, -0.9), (0.0, 1.0, 0.0), 75.0, 16, 16)
    return Case(
        name=name,
        family="spectral",
        title=f"Closed room in {light} in every bounce",
        scene=Scene(walls, sensor),
        answer=Formula(uniform_field, "white furnace test per wavelength; illuminants: CIE 15:2018"),
        bounces=5,
        tolerance=Tolerance(image=(0.005,), tile=(0.02,)),
        derivation=_FURNACE,
        blind_to=(
            "wrongly distributed rays, since every direction carries the same radiance; albedos that are mixed up "
            "between wavelengths, since all are the same"
        ),
        wavelengths=_VISIBLE,
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "cornell-box-spectral": cornell_box_spectral,
    "furnace-equal-energy": furnace_equal_energy,
    "furnace-d65": furnace_d65,
}
