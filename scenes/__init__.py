"""What is rendered, and what the answer is: scenes, cases, closed forms. It knows no renderer."""

from scenes.case import Case, Estimate, Formula, Tolerance, Truth
from scenes.lights import AreaLight, PolarRange
from scenes.materials import Lambertian
from scenes.names import UnknownNameError
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.surfaces import Quad, Sphere, Surface, box
from scenes.validation import SceneError

__all__ = [
    "AreaLight",
    "Case",
    "Estimate",
    "Formula",
    "Lambertian",
    "Pinhole",
    "PolarRange",
    "Quad",
    "Scene",
    "SceneError",
    "Sphere",
    "Surface",
    "Tolerance",
    "Truth",
    "UnknownNameError",
    "box",
]
