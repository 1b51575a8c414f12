"""How much each thing that can be seen speaks for each operator; roughly logarithms of likelihood ratios.

Set on the planted faults of ``comparisons.faults`` but those of its ``held_out``, and judged on these.
"""

from __future__ import annotations

from collections.abc import Mapping

from comparisons.diagnosis.clue import Weights
from comparisons.diagnosis.patterns import Kind

PATTERNS: Mapping[Kind, Weights] = {
    "error": {},
    "none of E": {"E": 5},
    "dark from": {"series": 4},
    "light after the last": {"series": 4},
    "sums": {"series": 7},
    "counted from another number": {"series": 6},
    "same factor": {"E": 2, "sensor": 2},
    "same factor from 1": {"estimator": 2.5, "E": 0.5},
    "factor by factor": {"R": 4},
    "one bounce": {"series": 3.5},
    "later bounces": {"series": 2, "sampler": 0.5, "R": 0.5},
    "only E": {"E": 1.5, "sensor": 2, "series": 1.5},
    "places": {"sensor": 1.5, "sampler": 0.5, "R": 0.5, "G": 0.5},
    "direct": {"R": 0.5, "G": 0.5, "estimator": 0.5, "E": 0.5},
    "irregular": {"G": 0.5, "R": 0.5, "sensor": 0.5},
}

TOTAL: Weights = {"series": 5.0}
"""What ends a walk, or counts what goes on, decides which bounces are in the sum and how often."""

DARK_IN_SOME: Weights = {"R": 0.5, "G": 0.5, "estimator": 0.5, "E": 0.5}
"""Where other cases have light in these bounces, they are not lost altogether."""

HINTS: Mapping[str, Weights] = {
    "turned": {"sensor": 5},
    "encoded": {"sensor": 5},
    "exchanged": {"sensor": 3},
    "clipped": {"sensor": 7},
    "shifted": {"sensor": 4},
    "soft": {"sensor": 4},
    "bounces": {"series": 0.5},
    "scaled": {},
}

MATERIAL: Weights = {"R": 4.0}
DELTA_LIGHT: Weights = {"E": 5.5}
ENVIRONMENT: Weights = {"E": 4.0, "G": 0.5}
SCALED_SHAPE: Weights = {"E": 4.0, "G": 1.5, "estimator": 1.5}  # its area, mostly: what it emits
ROUND_SHAPE: Weights = {"estimator": 2.5, "G": 2.0}
FEATURES: Mapping[str, Weights] = {
    "mirror": MATERIAL,
    "conductor": MATERIAL,
    "dielectric": MATERIAL,
    "rough_conductor": MATERIAL,
    "rough_dielectric": MATERIAL,
    "blend": MATERIAL,
    "point": DELTA_LIGHT,
    "spot": DELTA_LIGHT,
    "directional": DELTA_LIGHT,
    "constant": ENVIRONMENT,
    "environment_map": ENVIRONMENT,
    "spherical_harmonics": ENVIRONMENT,
    "sphere": ROUND_SHAPE,
    "disk": SCALED_SHAPE,
    "ellipsoid": SCALED_SHAPE,
    "inward": ROUND_SHAPE,
    "image texture": {"R": 7.0},  # outweighs that its edges look soft, or its places exchanged
    "checkerboard texture": {"R": 7.0},
    "lambertian": {"R": 3.0},
    "mesh": {"G": 3.0},
    "shading normals": {"G": 3.0},
    "polar_range": {"E": 2.0, "estimator": 1.0},
    "angular_profile": {"E": 4.0},
    "lights infinitely far": {"E": 4.0, "G": 0.5},
    "lights at a point": {"E": 4.0},
    "metal": {"R": 4.0},
    "glass": {"R": 4.0},
    "orthographic": {"sensor": 1.0},
    "thin_lens": {"sensor": 3.0},
    "irradiance_meter": {"sensor": 3.0},
    "an image that is not square": {"sensor": 5.0},
    "things that hide others": {"G": 5.0},
    "an unusual size": {"G": 5.0},
    "several emitters": {"estimator": 3.0},
}

FAR = frozenset(("directional", "constant", "environment_map", "spherical_harmonics"))
OF_A_KIND: Mapping[str, frozenset[str]] = {
    "lights infinitely far": FAR,
    "lights at a point": frozenset(("point", "spot")),
    "metal": frozenset(("conductor", "rough_conductor")),
    "glass": frozenset(("dielectric", "rough_dielectric")),
}
"""Features that FEATURES also speaks of together; what is said of one of them is not said of its kind again."""

RIGHT_ELSEWHERE: Weights = {
    "G": 1.0,
    "E": 0.5,
    "R": -1.5,
    "estimator": -0.5,
}  # where things stand is what differs

FIRST_HITS: Weights = {"G": 4.0}  # closed forms tell more than one image does of another
RELATIONS: Mapping[str, Weights] = {
    "E": {"E": 2.0},
    "G": {"G": 2.0},
    "R": {"R": 2.0},
    "sensor": {"sensor": 2.0},
    "estimator": {"estimator": 2.0},
}
OTHER_CAMERA: Weights = {"sensor": 7.0}
SCALING: Weights = {"G": 5.0, "series": -1.5}  # an offset, or an end of rays
SCALING_OF_LAMPS: Weights = {"G": 2.0, "E": 1.5, "estimator": 1.5}  # or how a lamp is sampled, or falls off
SPP: Weights = {"sensor": 5.0, "estimator": -1.0}  # what is done to the finished image sees its noise
ROLL: Weights = {"sensor": 5.0}
PARTIAL_SUMS: Weights = {"series": 7.0}

HIDDEN = frozenset(
    (
        "screened-lamp",
        "disk-shadow",
        "lamp-over-a-wall",
        "block-over-plane",
        "wall-behind-a-shelf",
        "around-the-corner",
    )
)
"""Cases about one thing that hides another."""

OCCLUDED = HIDDEN | {
    *(
        "furnace-channels",
        "furnace-bright",
        "furnace-tiny",
        "furnace-huge",
        "furnace-cornell",
        "furnace-mesh",
    ),
    *(
        "furnace-blend",
        "furnace-mirrors",
        "rough-glass-tank",
        "sphere-zones",
        "cornell-box",
        "cie-171-opening",
    ),
}
"""Cases in which something stands between others."""

SIZED = frozenset(("furnace-tiny", "furnace-huge"))
SHAPES = frozenset(("sphere", "mesh", "disk", "ellipsoid"))  # besides quads, which all scenes have
STRETCHED = frozenset(("disk", "ellipsoid"))
DRAWN = frozenset(("area", "constant", "environment_map", "spherical_harmonics"))
DELTA = frozenset(("point", "spot", "directional"))
SMOOTH = frozenset(("mirror", "conductor", "dielectric"))
SPECIAL = frozenset(("mirror", "conductor", "dielectric", "rough_conductor", "rough_dielectric", "blend"))
LIGHTS = DRAWN | DELTA
MATERIALS = SPECIAL | {"lambertian", "image texture", "checkerboard texture"}
