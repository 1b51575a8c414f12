"""A minimal program that shows the finding beside this file. Needs Mitsuba 3 and LLVM; a minute."""

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)
RENDERS = 48


def room(integrator: str, lit: bool = False) -> mi.Scene:
    """Inside of a sphere that reflects, and emits from a quarter of its latitudes, or from all."""
    rows = np.full((4, 1, 3), 4.0 if lit else 0.0, dtype=np.float32)
    rows[0] = 4.0
    picture = {"type": "bitmap", "data": mi.TensorXf(rows), "raw": True, "filter_type": "nearest"}
    colour = {"type": "rgb", "value": [0.8, 0.6, 0.4]}
    ball = {
        "type": "sphere",
        "flip_normals": True,
        "bsdf": {"type": "diffuse", "reflectance": colour},
        "emitter": {"type": "area", "radiance": picture | {"wrap_mode": "clamp"}},
    }
    sensor = {
        "type": "perspective",
        "fov": 90,
        "to_world": mi.ScalarTransform4f().look_at([0.25, 0.1, -0.3], [-0.1, 0.25, 0.6], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}},
    }
    return mi.load_dict({"type": "scene", "integrator": {"type": integrator}, "ball": ball, "sensor": sensor})


for integrator, lit in (("path", False), ("volpath", False), ("volpathmis", False), ("volpathmis", True)):
    scene = room(integrator, lit)
    wrong = [np.isnan(mi.render(scene, spp=64, seed=seed)).any(axis=-1).sum() for seed in range(RENDERS)]
    print(
        f"{integrator:10} {'all of it' if lit else 'a quarter':9} emits: {np.count_nonzero(wrong)} of {RENDERS} "
        f"images have a pixel that is NaN; {sum(wrong)} of {RENDERS * 64 * 64} pixels"
    )
