"""A minimal program that shows the finding beside this file. Needs Mitsuba 3 and LLVM; two minutes."""

import drjit as dr
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


def lamp(shape: str) -> mi.Scene:
    """A lamp with a picture that is 4 everywhere."""
    white = {
        "type": "bitmap",
        "data": mi.TensorXf(np.full((4, 4, 3), 4.0)),
        "raw": True,
        "filter_type": "nearest",
    }
    return mi.load_dict(
        {"type": "scene", "lamp": {"type": shape, "emitter": {"type": "area", "radiance": white}}}
    )


print("The lamp's sample, seen from (0.1, 0.2, 3):")
point = dr.zeros(mi.SurfaceInteraction3f)
point.p = mi.Point3f(0.1, 0.2, 3)
for shape, numbers in (
    ("sphere", (0.3, 0)),
    ("sphere", (0.3, 2.0**-23)),
    ("disk", (0, 0.3)),
    ("disk", (2.0**-23, 0.3)),
):
    found, weight = lamp(shape).sample_emitter_direction(point, numbers, False)
    density, quotient, product = found.pdf[0], weight[0][0], (weight * found.pdf)[0][0]
    print(
        f"{shape:6} numbers {numbers[0]:.2g}, {numbers[1]:.2g}: density {density:.3g}, L / density {quotient:.2g}, "
        f"their product {product:.3g}"
    )

print("\nInside of the sphere:")
for variant, integrator, lit, renders in (
    ("llvm_ad_rgb", "path", False, RENDERS),
    ("llvm_ad_rgb", "volpath", False, RENDERS),
    ("llvm_ad_rgb", "volpathmis", False, RENDERS),
    ("llvm_ad_rgb", "volpathmis", True, RENDERS),
    ("scalar_rgb", "volpathmis", False, RENDERS // 3),
):
    mi.set_variant(variant)
    scene = room(integrator, lit)
    wrong = [np.isnan(mi.render(scene, spp=64, seed=seed)).any(axis=-1).sum() for seed in range(renders)]
    print(
        f"{variant:11} {integrator:10} {'all of it' if lit else 'a quarter':9} emits: {np.count_nonzero(wrong)} of "
        f"{renders} images have a pixel that is NaN; {sum(wrong)} of {renders * 64 * 64} pixels"
    )
