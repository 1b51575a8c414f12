"""A minimal scene that shows the finding beside this file. Needs Mitsuba 3 only; takes seconds."""

from itertools import pairwise

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_spectral")
VIEW = mi.ScalarTransform4f().look_at(origin=[0, 0, 2], target=[0, 0, 0], up=[0, 1, 0])

print("a lamp of radiance 1 at every wavelength fills the image; the film has bands between 400 and 700 nm")
for bands in range(1, 6):
    film = {
        "type": "specfilm",
        "width": 4,
        "height": 4,
        "rfilter": {"type": "box"},
        "component_format": "float32",
    }
    edges = np.linspace(400, 700, bands + 1)
    for i, (low, high) in enumerate(pairwise(edges)):
        nodes = f"{low}, {low + 1}, {high - 1}, {high}"
        film[f"band{i}"] = {"type": "irregular", "wavelengths": nodes, "values": "0, 1, 1, 0"}
    lamp = {"type": "rectangle", "emitter": {"type": "area", "radiance": {"type": "uniform", "value": 1.0}}}
    sensor = {"type": "perspective", "fov": 30, "to_world": VIEW, "film": film}
    scene = mi.load_dict({"type": "scene", "lamp": lamp, "sensor": sensor})
    print(f"{bands} bands, exactly {300 / bands - 1:.2f} in each")
    for name in ("path", "ptracer"):
        try:
            image = mi.render(scene, integrator=mi.load_dict({"type": name, "max_depth": 1}), spp=4096)
            print(f"    {name:8}", np.array(image).mean(axis=(0, 1)).round(2))
        except RuntimeError as error:
            print(f"    {name:8}", str(error).strip().splitlines()[0])
