"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes half a minute."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
scene = mi.load_dict(
    {
        "type": "scene",
        "sensor": {
            "type": "perspective",
            "fov": 90,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=[0.2, 0.1, -0.3], target=[0, 0.2, 1], up=[0, 1, 0]
            ),
            "film": {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
        "sphere": {
            "type": "sphere",
            "flip_normals": True,
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        },
    }
)

print("direct light, 0.5 everywhere by the white furnace test")
for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
    integrator = mi.load_dict(
        {
            "type": "direct",
            "emitter_samples": emitter_samples,
            "bsdf_samples": bsdf_samples,
            "hide_emitters": False,
        }
    )
    mean = np.array(mi.render(scene, integrator=integrator, spp=256, seed=1)).mean() - 1.0
    print(f"  {emitter_samples} emitter, {bsdf_samples} BSDF samples: {mean:.5f}")

print("density of sample_direction() ÷ pdf_direction() for the same direction, points on the sphere")
sphere, rng = scene.shapes()[0], np.random.default_rng(1)
ratios = []
for _ in range(20_000):
    d = mi.Vector3f(mi.warp.square_to_uniform_sphere(rng.random(2)))
    si = scene.ray_intersect(mi.Ray3f([0.2, 0.1, -0.3], d))
    sample = sphere.sample_direction(si, rng.random(2))
    ratios.append(sample.pdf / sphere.pdf_direction(si, sample))
wrong = np.abs(np.array(ratios) - 1) > 0.01
print(f"  {wrong.mean():.1%} of the points disagree")

print("bounce k, exactly 0.5^k: coupled renders of depth k + 1 and k, one sample each, random seeds")
film = 64 * 64
depths = [mi.load_dict({"type": "path", "max_depth": d, "rr_depth": 1 << 30}) for d in range(1, 7)]
terms = []
for seed in rng.integers(2**32 // film, size=600):
    sums = [np.array(mi.render(scene, integrator=path, spp=1, seed=int(seed))).mean() for path in depths]
    terms.append(np.diff(sums, prepend=0.0))
deviation = np.array(terms) / 0.5 ** np.arange(6) - 1
for k, (mean, error) in enumerate(
    zip(deviation.mean(0), deviation.std(0) / np.sqrt(len(deviation)), strict=True)
):
    print(f"  bounce {k}: {mean:+.3%} ± {error:.3%}")
