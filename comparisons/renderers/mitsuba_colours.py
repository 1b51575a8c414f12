"""Channels of a scene as Mitsuba's colours: three numbers, or bands of wavelengths.

``RGB``. A spectrum is three numbers, which Mitsuba's rgb variants multiply as they are.

``Bands``. Spectral variants make a smooth spectrum of three numbers, and the product of two such spectra is not the
spectrum of the product: (ρ_rgb)ᵏ is not what they compute. But they do compute with every wavelength by itself. So
the range 360 … 830 nm is cut into as many bands of 8 h as the scene has channels; a spectrum is constant in each, and
the film has a response for each, a trapezoid

    h 2h      6h 7h        of height 1, zero where the spectrum passes from one band's value to the next,
     ╱▔▔▔▔▔▔▔▔╲            whose integral is 5 h

so that a channel of the image is 5 h times the radiance. Which wavelengths they are matters to nothing: no material
here has dispersion but by its spectra. h is a power of two, and what the film takes for its sampling density has its
nodes where the responses have theirs.

``Grey``. ``ptracer`` puts sRGB into the film, whatever the film is. Where all channels of a scene are the same, its
spectra are ``uniform``, and the luminance Y of what comes back is the radiance: Mitsuba scales the CIE's ȳ(λ) so that
a spectrum of 1 has Y = 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba_names import Form
from comparisons.renderers.protocol import Unsupported

Array = NDArray[np.float64]
Dict = dict[str, Any]

_FIRST, _LAST = 360.0, 830.0
"""Of Mitsuba's wavelengths, nm."""

_LUMINANCE = (0.212671, 0.715160, 0.072169)
"""Y of linear sRGB: the middle row of the inverse of Mitsuba's ``xyz_to_srgb``."""

_HDR = {"type": "hdrfilm", "pixel_format": "rgb", "component_format": "float32"}


class Colours(Protocol):
    """How channels are put to Mitsuba, and read back.

    Attributes:
        mi: the module, its variant set.
    """

    mi: Any

    def film(self) -> Dict:
        """The film, but for its size and filter."""

    def spectrum(self, values: Sequence[float]) -> Dict:
        """A value per channel."""

    def picture(self, pixels: Array) -> Array:
        """Pixels of a texture, ``(rows, columns, channels)``, as a bitmap that is used raw.

        Raises:
            Unsupported: the variant would make something else of them.
        """

    def sky(self, pixels: Array) -> Array:
        """Pixels of an environment map; see ``picture``."""

    def radiance(self, image: Array) -> Array:
        """What the film has, as radiance per channel of the scene, ``(height, width, channels)``."""


def colours(mi: Any, form: Form, channels: int) -> Colours:
    """Those of a form of Mitsuba.

    Args:
        mi: the module, its variant set.
        form: its variant decides, and whether it is ``ptracer``.
        channels: of the scene.

    Raises:
        Unsupported: the variant has not as many channels.
    """
    if not form.spectral:
        if channels != 3:
            raise Unsupported(f"{channels} channels: {form.variant} has 3")
        return RGB(mi)
    return Grey(mi, channels) if form.integrator == "ptracer" else Bands(mi, channels)


class RGB:
    """Three channels, as they are."""

    def __init__(self, mi: Any) -> None:
        self.mi = mi

    def film(self) -> Dict:
        """See ``Colours``, also below."""
        return dict(_HDR)

    def spectrum(self, values: Sequence[float]) -> Dict:
        """Three numbers."""
        return {"type": "rgb", "value": list(values)}

    def picture(self, pixels: Array) -> Array:
        """As they are."""
        return pixels

    def sky(self, pixels: Array) -> Array:
        """As they are."""
        return pixels

    def radiance(self, image: Array) -> Array:
        """As it is."""
        return image


class _Spectral:
    def __init__(self, mi: Any, channels: int) -> None:
        self.mi = mi
        self._channels = channels

    def picture(self, pixels: Array) -> Array:
        """One channel, if all are the same."""
        if np.ptp(pixels, axis=-1).any():
            raise Unsupported("a coloured picture: a spectral variant makes smooth spectra of its pixels")
        return pixels[..., :1]

    def sky(self, pixels: Array) -> Array:
        """None: the light of a picture is multiplied by the spectrum D65."""
        raise Unsupported("an environment map: a spectral variant multiplies its pixels by the spectrum D65")


class Bands(_Spectral):
    """A band of wavelengths for every channel."""

    def __init__(self, mi: Any, channels: int) -> None:
        super().__init__(mi, channels)
        self._h = 2.0 ** math.floor(math.log2((_LAST - _FIRST) / (8 * channels)))

    def film(self) -> Dict:
        """A response for every band."""
        bands = {
            f"band{i:04}": _irregular([self._at(i, step) for step in (1, 2, 6, 7)], [0.0, 1.0, 1.0, 0.0])
            for i in range(self._channels)
        }
        return {"type": "specfilm", "component_format": "float32"} | bands

    def spectrum(self, values: Sequence[float]) -> Dict:
        """Constant in each band."""
        if len(set(values)) == 1:
            return {"type": "uniform", "value": values[0]}
        nodes = [self._at(i, step) for i in range(self._channels) for step in (1, 7)]
        return _irregular(nodes, np.repeat(values, 2).tolist())

    def radiance(self, image: Array) -> Array:
        """A channel over the integral of its response."""
        return image / (5 * self._h)

    def _at(self, band: int, step: int) -> float:
        return _FIRST + (8 * band + step) * self._h


class Grey(_Spectral):
    """The same in all channels."""

    def film(self) -> Dict:
        """Of sRGB."""
        return dict(_HDR)

    def spectrum(self, values: Sequence[float]) -> Dict:
        """The same at every wavelength."""
        if len(set(values)) > 1:
            raise Unsupported("colour: ptracer gives the film sRGB, of which no spectrum can be told")
        return {"type": "uniform", "value": values[0]}

    def radiance(self, image: Array) -> Array:
        """Its luminance, in every channel."""
        return np.repeat((image @ np.array(_LUMINANCE))[..., None], self._channels, axis=-1)


def _irregular(nodes: Sequence[float], values: Sequence[float]) -> Dict:
    lists = {"wavelengths": nodes, "values": values}
    return {"type": "irregular"} | {name: ", ".join(map(repr, numbers)) for name, numbers in lists.items()}
