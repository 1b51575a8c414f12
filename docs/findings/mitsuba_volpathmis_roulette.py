"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes a minute."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f
NONE = 1 << 30
WHOLE_TURN = [
    T(),
    T().rotate([1, 0, 0], 180),
    *(T().rotate(a, d) for a in ([1, 0, 0], [0, 1, 0]) for d in (90, -90)),
]


def cube(glowing: bool) -> mi.Scene:
    """A cube of half edge 1, walls inwards, albedo ½; they emit 1, or a point light hangs in it."""
    view = T().look_at(origin=[0.3, -0.2, 0.7], target=[-0.2, 0.1, -1], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
    emission = {"emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}} if glowing else {}
    lamp = {
        "lamp": {"type": "point", "position": [0.4, 0.5, 0.2], "intensity": {"type": "rgb", "value": 1.0}}
    }
    walls = {
        f"wall{i}": {
            "type": "rectangle",
            "to_world": turn @ T().translate([0, 0, -1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
        }
        | emission
        for i, turn in enumerate(WHOLE_TURN)
    }
    camera = {
        "type": "perspective",
        "fov": 90,
        "to_world": view,
        "film": film,
        "sampler": {"type": "independent"},
    }
    return mi.load_dict({"type": "scene", "sensor": camera, **walls} | ({} if glowing else lamp))


def mean(scene: mi.Scene, integrator: str, rr_depth: int) -> str:
    """Of the image, without limit of depth."""
    own = mi.load_dict({"type": integrator, "rr_depth": rr_depth, "max_depth": 40})
    means = [np.array(mi.render(scene, integrator=own, spp=64, seed=seed)).mean() for seed in range(32)]
    return f"{np.mean(means):.4f} ± {np.std(means, ddof=1) / np.sqrt(32):.4f}"


for title, glowing in (
    ("every wall emits 1: the sum is 2", True),
    ("a point light, no weights of strategies", False),
):
    scene = cube(glowing)
    print(f"{title}\nrr_depth        path              volpath           volpathmis")
    for rr_depth in (NONE, 8, 5, 3, 2, 1):
        row = "   ".join(
            mean(scene, integrator, rr_depth) for integrator in ("path", "volpath", "volpathmis")
        )
        print(f"{'none' if rr_depth == NONE else rr_depth:<12}    {row}")
