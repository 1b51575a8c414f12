"""What a renderer of unknown faults is put to: cases that tell much in little time, in the order of what they tell.

First what every renderer has, one operator after the other; then one kind of lamp, shape and material after the
other. ``THOROUGH`` follows where nothing was found: it takes longer.
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
    "lamp-turned-away",
    "moved-disk",
    "ellipsoid-over-plane",
    "elliptical-disk-over-plane",
    "triangle-over-plane",
    "spot-falloff",
    "bright-texel",
    "disk-shadow",
    "printed-board",
    "metal-angles",
    "lamp-under-water",
    "rough-metal-sky",
    "rough-metal-sun",
    "snells-window",
    "rough-glass-tank",
    "blend-sun",
    "blend-sky",
    "constant-radiance-mirror",
    "cie-171-panel",
)
THOROUGH = (
    "furnace-channels",
    "hundred-tiles",
    "shading-normals-from-behind",
    "lit-from-behind",
    "harmonics-on-sphere",
    "furnace-mirrors",
    "point-in-sphere",
    "furnace-tiny",
    "furnace-mesh",
    "cie-171-opening",
    "cie-171-glass",
    "rough-glass-sun",
    "blend-lamp",
    "furnace-cornell",
    "furnace-huge",
    "furnace-blend",
    "wall-behind-a-shelf",
    "four-points",
    "glass-ball",
    "sphere-zones",
    "constant-radiance-blend",
    "cornell-box",
)


@cache
def case(name: str) -> Case:
    """A case of the library whose answer is worked out once for all renderers of this process."""
    found = library.case(name)
    answer = found.answer
    if not isinstance(answer, Formula):
        return found
    return replace(found, answer=replace(answer, evaluate=cache(answer.evaluate)))
