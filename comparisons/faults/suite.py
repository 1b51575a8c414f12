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
    "furnace-channels",
    "hundred-tiles",
    "spot-falloff",
    "moved-disk",
    "triangle-over-plane",
    "bright-texel",
    "metal-angles",
    "lamp-under-water",
    "rough-metal-sky",
    "rough-metal-sun",
    "snells-window",
    "rough-glass-tank",
    "blend-sun",
    "constant-radiance-mirror",
    "cie-171-panel",
)
THOROUGH = (
    "lit-from-behind",
    "shading-normals-from-behind",
    "disk-shadow",
    "elliptical-disk-over-plane",
    "ellipsoid-over-plane",
    "blend-sky",
    "rough-glass-sun",
    "point-in-sphere",
    "harmonics-on-sphere",
    "furnace-mirrors",
    "blend-lamp",
    "furnace-tiny",
    "furnace-cornell",
    "furnace-huge",
    "furnace-blend",
    "furnace-mesh",
    "cie-171-opening",
    "cie-171-glass",
    "sphere-zones",
    "wall-behind-a-shelf",
    "constant-radiance-blend",
    "four-points",
    "glass-ball",
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
