"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes a minute."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f


def furnace(size: float) -> mi.Scene:
    """A cube of half edge ``size``, walls inwards, albedo ½, emission 1, seen from a point off its centre."""
    view = T().look_at(
        origin=[0.3 * size, -0.2 * size, 0.7 * size], target=[-0.2 * size, 0.1 * size, -size], up=[0, 1, 0]
    )
    film = {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}}
    turns = [
        T(),
        T().rotate([1, 0, 0], 180),
        *(T().rotate(a, d) for a in ([1, 0, 0], [0, 1, 0]) for d in (90, -90)),
    ]
    walls = {
        f"wall{i}": {
            "type": "rectangle",
            "to_world": T().scale(size) @ turn @ T().translate([0, 0, -1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        }
        for i, turn in enumerate(turns)
    }
    camera = {"type": "perspective", "fov": 90, "near_clip": 1e-6 * size, "to_world": view, "film": film}
    # optimised, the lamps come in the order of their addresses, and the same seed gives another image each time
    return mi.load_dict(
        {"type": "scene", "sensor": camera | {"sampler": {"type": "independent"}}, **walls}, optimize=False
    )


print("direct light, 0.5 everywhere by the white furnace test, whatever the size")
print("size    emitter samples      BSDF samples         both")
for size in (100.0, 1.0, 1e-2, 1e-3, 1e-4):
    scene, cells = furnace(size), []
    for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
        direct = {"emitter_samples": emitter_samples, "bsdf_samples": bsdf_samples, "hide_emitters": False}
        integrator = mi.load_dict({"type": "direct"} | direct)
        means = [
            np.array(mi.render(scene, integrator=integrator, spp=64, seed=s)).mean() - 1 for s in range(1, 17)
        ]
        cells.append(f"{np.mean(means):.5f} ± {np.std(means, ddof=1) / 4:.5f}")
    print(f"{size:<7g} " + "   ".join(cells))
