"""What a renderer of unknown faults is put to: cases that tell much in little time, in the order of what they tell.

First what every renderer has, one operator after the other; then one kind of lamp, shape and material after the
other. ``THOROUGH`` follows where nothing was found: it takes longer, and each of its cases has caught a planted fault
that all before it had passed.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from scenes import Case, Formula, library

QUICK = (
    "furnace-sphere",
    "quad-over-plane",
    "point-over-plane",
    "screened-lamp",
    "integrating-sphere",
    "directional-on-sphere",
    "sphere-over-plane",
    "furnace-convex",
    "bright-texel",
    "snells-window",
    "rough-metal-sky",
    "metal-angles",
    "lamp-under-water",
    "lamp-turned-away",
    "rough-glass-tank",
    "rough-metal-sun",
    "spot-falloff",
    "elliptical-disk-over-plane",
    "disk-shadow",
    "printed-board",
    "ellipsoid-over-plane",
    "blend-sun",
    "moved-disk",
    "constant-radiance-mirror",
    "cie-171-panel",
    "triangle-over-plane",
)
THOROUGH = (
    "blend-sky",
    "furnace-channels",
    "harmonics-on-sphere",
    "furnace-mirrors",
    "hundred-tiles",
    "shading-normals-from-behind",
    "lit-from-behind",
    "furnace-tiny",
    "furnace-huge",
    "point-in-sphere",
    "furnace-mesh",
    "cie-171-opening",
)


@cache
def case(name: str) -> Case:
    """A case of the library whose answer is worked out once for all renderers of this process."""
    found = library.case(name)
    answer = found.answer
    if not isinstance(answer, Formula):
        return found
    return replace(found, answer=replace(answer, evaluate=cache(answer.evaluate)))
