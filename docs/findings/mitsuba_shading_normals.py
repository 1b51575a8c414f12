"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes seconds."""

import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
CORNERS = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
SHADING_NORMAL = np.array([0.6, 0.0, 0.8])  # all three corners; the triangle itself faces +z


def unit(v):
    """v with length 1."""
    return np.asarray(v) / np.linalg.norm(v)


def triangle(folder, **options):
    """The triangle, with one tilted normal at all of its corners."""
    mesh = mi.Mesh("triangle", vertex_count=3, face_count=1, has_vertex_normals=True)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = CORNERS.ravel().astype(np.float32)
    parameters["vertex_normals"] = np.tile(SHADING_NORMAL, 3).astype(np.float32)
    parameters["faces"] = np.arange(3, dtype=np.uint32)
    parameters.update()
    mesh.write_ply(str(folder / "triangle.ply"))
    return {"type": "ply", "filename": str(folder / "triangle.ply")} | options


def diffuse(albedo):
    """A diffuse BSDF."""
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo}}


def meter(origin, target):
    """A sensor for the radiance along one ray."""
    film = {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}}
    direction = list(np.subtract(target, origin))
    return {"type": "radiancemeter", "origin": list(origin), "direction": direction, "film": film}


def lambert(x, normal):
    """Irradiance at x from the triangle with radiance 1, whole in front of x (Lambert 1760)."""
    to = [unit(corner - x) for corner in CORNERS]
    edges = [(to[i], to[(i + 1) % 3]) for i in range(3)]
    return abs(sum(np.arccos(a @ b) * (unit(np.cross(a, b)) @ normal) for a, b in edges)) / 2


folder = Path(tempfile.mkdtemp())

x, down = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])
lamp = triangle(
    folder, bsdf=diffuse(0.0), emitter={"type": "area", "radiance": {"type": "rgb", "value": 1.0}}
)
receiver = {
    "type": "disk",
    "to_world": mi.ScalarTransform4f().look_at(origin=x, target=x + down, up=[0, 1, 0]).scale(0.01),
    "bsdf": diffuse(1.0),
}
scene = mi.load_dict({"type": "scene", "lamp": lamp, "receiver": receiver, "sensor": meter([0.5, 0, 0.5], x)})
print(f"what a white point above an emitting triangle reflects, exactly {lambert(x, down) / np.pi:.5f}")
for emitter_samples, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
    integrator = mi.load_dict(
        {"type": "direct", "emitter_samples": emitter_samples, "bsdf_samples": bsdf_samples}
    )
    means = [np.array(mi.render(scene, integrator=integrator, spp=50_000, seed=i))[..., 0] for i in range(8)]
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    print(f"  {emitter_samples} emitter, {bsdf_samples} BSDF samples: {np.mean(means):.5f} ± {error:.5f}")

print("the triangle, white, under a directional light of irradiance 1")
for name, to_viewer, to_light in (
    ("light and viewer in front", (0, 0, 1), (0.3, 0.2, 1)),
    ("light behind, exactly 0", (0, 0, 1), (1, 0, -0.2)),
    ("viewer behind, exactly 0", (1, 0, -0.2), (0, 0, 1)),
):
    sun = {
        "type": "directional",
        "direction": list(-unit(to_light)),
        "irradiance": {"type": "rgb", "value": 1.0},
    }
    sensor = meter(unit(to_viewer), [0, 0, 0])
    white = triangle(folder, bsdf=diffuse(1.0))
    scene = mi.load_dict({"type": "scene", "triangle": white, "sun": sun, "sensor": sensor})
    image = mi.render(scene, integrator=mi.load_dict({"type": "path", "max_depth": 2}), spp=1)
    print(f"  {name}: {np.array(image)[0, 0, 0]:.5f}")
