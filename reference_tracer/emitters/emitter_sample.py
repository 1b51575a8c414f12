"""What next-event estimation gets from an emitter: a direction, the radiance along it, and its density."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class EmitterSample:
    """Directions towards emitters, one for each of n reference points.

    The contribution is f · cos θ · Li / pdf wherever nothing lies between. A lane that can't contribute has
    Li = 0, and a pdf that does no harm.

    Attributes:
        wi: unit directions from the reference to the emitter, ``(3, n)``.
        distance: to the point chosen, ``(n,)``; inf for what is infinitely far.
        Li: radiance along wi, ``(channels, n)``. For point and spot lights intensity / distance², for
            directional ones their irradiance: what is left of the integral over directions.
        pdf: solid angle density of wi, the choice of the emitter included, ``(n,)``; for point, spot and
            directional lights the probability of the choice alone.
        delta: whether no other strategy could have found the direction: for each lane, or for all alike.
        primitive: the primitive on which the chosen point lies, ``(n,)``; NOWHERE if on none. It has already
            been seen to that it does not hide the point itself.
    """

    wi: Array
    distance: Array
    Li: Array
    pdf: Array
    delta: NDArray[np.bool_] | bool
    primitive: NDArray[np.intp]

    def __getitem__(self, lanes: NDArray[np.intp]) -> EmitterSample:
        return EmitterSample(
            self.wi.take(lanes, axis=1),
            self.distance.take(lanes),
            self.Li.take(lanes, axis=1),
            self.pdf.take(lanes),
            np.broadcast_to(self.delta, self.pdf.shape).take(lanes),
            self.primitive.take(lanes),
        )
