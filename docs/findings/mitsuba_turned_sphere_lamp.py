"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes half a minute."""

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

CAP = {
    "type": "bitmap",
    "bitmap": mi.Bitmap(np.array(5 * [[[0.0] * 3]] + [[[1.0] * 3]], dtype=np.float32)),
    "raw": True,
    "filter_type": "nearest",
}


def share(degrees):
    """What the cause leaves of emitter samples: the light of the points that are met, over that of those meant."""
    u, v = (np.mgrid[:400, :400] + 0.5) / 400
    theta, phi = v * np.pi / 6, 2 * np.pi * u
    local = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    p = np.einsum("ij,jkl->ikl", turn, local)
    cosine = (p * local).sum(
        0
    )  # the ray from p + local along -local enters at p, or leaves there if it starts inside
    met = np.where((cosine > 0) | (cosine < -0.5), p, p - 2 * cosine * local)
    z = np.einsum("ji,jkl->ikl", turn, met)[2]  # back in coordinates of the sphere
    return (np.sqrt(1 - z**2) * (z > np.cos(np.pi / 6))).mean() / np.sin(theta).mean()


exact = 0.5 * (1 - np.cos(np.pi / 6)) / 2
print(f"direct light in a sphere lit by a cap of 30°, albedo 0.5, exactly {exact:.5f} everywhere")
for degrees in (0, 60, 100, 110, 120, 140, 180):
    scene = mi.load_dict(
        {
            "type": "scene",
            "sphere": {
                "type": "sphere",
                "flip_normals": True,
                "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], degrees),
                "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
                "emitter": {"type": "area", "radiance": CAP},
            },
            "sensor": {
                "type": "perspective",
                "fov": 90,
                # along the axis of the turns, so that the cap itself is never in view
                "to_world": mi.ScalarTransform4f().look_at(
                    origin=[0, 0.3, 0], target=[0, 1, 0], up=[1, 0, 0]
                ),
                "film": {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}},
                "sampler": {"type": "independent"},
            },
        }
    )
    row = f"  turned by {degrees:3}°, formula {exact * share(degrees):.5f}:"
    for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
        integrator = mi.load_dict(
            {"type": "direct", "emitter_samples": emitter_samples, "bsdf_samples": bsdf_samples}
        )
        means = [np.array(mi.render(scene, integrator=integrator, spp=64, seed=i)).mean() for i in range(16)]
        row += f"  {np.mean(means):.5f} ± {np.std(means, ddof=1) / np.sqrt(len(means)):.5f}"
    print(row)
