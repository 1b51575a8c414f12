"""Coincident surfaces: two in the same place would leave it to rounding which of them a ray meets."""

from __future__ import annotations

from collections.abc import Sequence

from scenes.surfaces import Surface


def check_coincidence(surfaces: Sequence[Surface]) -> None:
    """Refuse surfaces that overlap in the same plane or on the same sphere.

    Raises:
        SceneError: naming both.
    """
