"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes seconds."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
WHITE = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}
BLACK = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
HALF = {
    "type": "bitmap",
    "bitmap": mi.Bitmap(np.array([[[1.0] * 3], [[0.0] * 3]], dtype=np.float32)),
    "raw": True,
    "filter_type": "nearest",
}
print("what a white point reflects that sees the lit half of a sphere, exactly 0.25")
for degrees in (0, 30, 60, 90, 180):
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], degrees)
    axis = np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))])
    across = np.array([axis[2], 0, -axis[0]])
    scene = mi.load_dict(
        {
            "type": "scene",
            "sphere": {
                "type": "sphere",
                "to_world": turn,
                "bsdf": BLACK,
                "emitter": {"type": "area", "radiance": HALF},
            },
            "receiver": {
                "type": "disk",
                "to_world": mi.ScalarTransform4f()
                .look_at(origin=2 * axis, target=[0, 0, 0], up=[0, 1, 0])
                .scale(0.01),
                "bsdf": WHITE,
            },
            "sensor": {
                "type": "radiancemeter",
                "origin": list(1.8 * axis + 0.5 * across),
                "direction": list(0.2 * axis - 0.5 * across),
                "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
            },
        }
    )
    row = f"  turned by {degrees:3}°:"
    for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
        integrator = mi.load_dict(
            {"type": "direct", "emitter_samples": emitter_samples, "bsdf_samples": bsdf_samples}
        )
        means = [
            np.array(mi.render(scene, integrator=integrator, spp=20_000, seed=i))[0, 0, 0] for i in range(8)
        ]
        row += f"  {np.mean(means):.5f} ± {np.std(means, ddof=1) / np.sqrt(len(means)):.5f}"
    print(row)
