"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes a quarter of a minute."""

import sys

import mitsuba as mi
import numpy as np

mi.set_variant(sys.argv[1] if len(sys.argv) > 1 else "llvm_ad_rgb")
VIEW = mi.ScalarTransform4f().look_at(origin=[0, 3, 4], target=[0, 0, 0], up=[0, 1, 0])
TEXEL = np.zeros((16, 32, 3), dtype=np.float32)
TEXEL[4, 15] = 1
SAMPLES, REPLICATES = 1024, 8


def mean(integrator: str, turn: float, axis: list[float]) -> tuple[float, float]:
    """Of direct light over the image of a ball under a sky with one bright texel, and its standard error."""
    sky = {
        "type": "envmap",
        "bitmap": mi.Bitmap(TEXEL),
        "to_world": mi.ScalarTransform4f().rotate(axis, turn),
    }
    film = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": 0.5}},
            "sky": sky,
            "sensor": {"type": "perspective", "fov": 25, "to_world": VIEW, "film": film},
        }
    )
    deep, shallow = (mi.load_dict({"type": integrator, "max_depth": depth}) for depth in (2, 1))
    found = [
        np.mean(mi.render(scene, integrator=deep, spp=SAMPLES, seed=seed))
        - np.mean(mi.render(scene, integrator=shallow, spp=SAMPLES, seed=1000 + seed))
        for seed in range(REPLICATES)
    ]
    return float(np.mean(found)), float(np.std(found, ddof=1) / np.sqrt(REPLICATES))


print("a diffuse ball under a dark sky with one bright texel, which is turned: direct light, times 1000")
for axis in ([0, 1, 0], [1, 0, 0]):
    for turn in (0, 30, 60, 90):
        cells = [f"{name} {1000 * m:.3f} ± {1000 * e:.3f}" for name in ("path", "ptracer")
                 for m, e in [mean(name, turn, axis)]]  # fmt: skip
        print(f"{turn:3} degrees about {'xyz'[axis.index(1)]}   {'   '.join(cells)}", flush=True)
