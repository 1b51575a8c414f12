"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes seconds."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
scene = mi.load_dict(
    {
        "type": "scene",
        "sensor": {
            "type": "perspective",
            "fov": 10,
            "to_world": mi.ScalarTransform4f().look_at(origin=[0.5, 0.3, 4], target=[0, 0, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
        "sphere": {
            "type": "sphere",
            "bsdf": {
                "type": "roughdielectric",
                "distribution": "ggx",
                "alpha": 0.4,
                "int_ior": 1.5,
                "ext_ior": 1.0,
            },
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        },
    }
)

print("what the sphere reflects of its own light, exactly 0: the whole image beyond the emitted 1")
for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
    integrator = mi.load_dict(
        {
            "type": "direct",
            "emitter_samples": emitter_samples,
            "bsdf_samples": bsdf_samples,
            "hide_emitters": False,
        }
    )
    means = [np.array(mi.render(scene, integrator=integrator, spp=64, seed=i)).mean() - 1.0 for i in range(8)]
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    print(f"  {emitter_samples} emitter, {bsdf_samples} BSDF samples: {np.mean(means):.5f} ± {error:.5f}")

print("emitter samples from points of the sphere")
rng = np.random.default_rng(1)
sphere, lit = scene.shapes()[0], []
for _ in range(20_000):
    x = scene.ray_intersect(
        mi.Ray3f([0.5, 0.3, 4], mi.Vector3f([-0.5, -0.3, -4]) + 0.8 * (rng.random(3) - 0.5))
    )
    if x.is_valid():
        sample, weight = scene.sample_emitter_direction(x, rng.random(2), True)
        lit.append(sample.dist if weight[0] > 0 else np.nan)
share = np.isfinite(lit).mean()
print(
    f"  {share:.1%} see its front, at a distance of {np.nanmedian(lit):.1g} (median), at most {np.nanmax(lit):.1g}"
)
