"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes seconds."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
path = mi.load_dict({"type": "path", "max_depth": 2, "rr_depth": 1 << 30})
print("weight of the mirror, exact, Mitsuba, formula with the two measures added")
for weight in (0.1, 0.25, 0.5, 0.75, 0.9):
    scene = mi.load_dict(
        {
            "type": "scene",
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
            "pane": {
                "type": "rectangle",
                "bsdf": {
                    "type": "blendbsdf",
                    "weight": weight,
                    "a_paint": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
                    "b_mirror": {"type": "conductor", "material": "none"},
                },
            },
            "sensor": {
                "type": "radiancemeter",
                "origin": [0, 0, 1],
                "direction": [0, 0, -1],
                "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
            },
        }
    )
    means = [np.array(mi.render(scene, integrator=path, spp=50_000, seed=i))[0, 0, 0] for i in range(8)]
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    exact = (1 - weight) * 0.5 + weight
    mirrored = (weight + (1 - weight) * 0.5 / np.pi) / (weight + (1 - weight) / np.pi)
    formula = (1 - weight) * 0.5 + weight * mirrored
    print(f"  {weight:.2f}  {exact:.5f}  {np.mean(means):.5f} ± {error:.5f}  {formula:.5f}")
