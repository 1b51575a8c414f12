"""What is rendered, and what the answer is: scenes, cases, closed forms. It knows no renderer."""

from scenes.affine import Affine
from scenes.case import Case, Computed, Estimate, Formula, Tolerance, Truth
from scenes.images import Image
from scenes.lights import (
    AreaLight,
    ConstantEnvironment,
    DeltaLight,
    DirectionalLight,
    Environment,
    EnvironmentMap,
    Light,
    PointLight,
    PolarRange,
    SphericalHarmonicsEnvironment,
    SpotLight,
)
from scenes.materials import (
    Blend,
    Checkerboard,
    Conductor,
    Dielectric,
    ImageTexture,
    Lambertian,
    Material,
    Mirror,
    RoughConductor,
    RoughDielectric,
    Texture,
)
from scenes.names import UnknownNameError
from scenes.scene import Scene
from scenes.sensor import IrradianceMeter, Orthographic, Pinhole, RadianceMeter, Sensor, ThinLens
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere
from scenes.surfaces import Surface, box
from scenes.transforms import transformed
from scenes.validation import SceneError

__all__ = [
    "Affine",
    "AreaLight",
    "Blend",
    "Case",
    "Checkerboard",
    "Computed",
    "Conductor",
    "ConstantEnvironment",
    "DeltaLight",
    "Dielectric",
    "DirectionalLight",
    "Disk",
    "Ellipsoid",
    "Environment",
    "EnvironmentMap",
    "Estimate",
    "Formula",
    "Image",
    "ImageTexture",
    "IrradianceMeter",
    "Lambertian",
    "Light",
    "Material",
    "Mesh",
    "Mirror",
    "Orthographic",
    "Pinhole",
    "PointLight",
    "PolarRange",
    "Quad",
    "RadianceMeter",
    "RoughConductor",
    "RoughDielectric",
    "Scene",
    "SceneError",
    "Sensor",
    "Shape",
    "Sphere",
    "SphericalHarmonicsEnvironment",
    "SpotLight",
    "Surface",
    "Texture",
    "ThinLens",
    "Tolerance",
    "Truth",
    "UnknownNameError",
    "box",
    "transformed",
]
