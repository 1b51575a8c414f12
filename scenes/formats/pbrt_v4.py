"""A scene as pbrt-v4's text.

Conventions that are translated here:

- pbrt's camera space is left-handed; ``Scale -1 1 1`` before ``LookAt`` keeps right on the right. Its field of view
  is across the smaller axis of the image, as ours.
- Its spheres and disks face outwards and along +z, its triangles where their corners run counterclockwise;
  ``ReverseOrientation`` turns one over.
- ``maxdepth = n`` holds bounces 0 … n: edit the line of the integrator. Its Russian roulette can't be switched off;
  it costs noise, no bias.
- Named materials are global, so each name is used once; the parts of a ``mix`` come before it.
- Its film writes 16-bit floats, 5·10⁻⁴ coarse, unless told not to.
- Its film divides by what a white light of radiance 1 makes of it, so a grey light keeps its numbers. A coloured one
  is fitted by a smooth spectrum (Jakob and Hanika 2019), which misses its channels by one or two thousandths: as much
  as a careful comparison can see. One channel at a time is exact, and the header says so.

What differs, and is refused:

- pbrt renders spectra. An RGB reflectance becomes a smooth spectrum, and the product of two of them is no product
  per channel, so a reflectance must be grey. One channel of a scene (``--channel``) is grey throughout.
- Its materials reflect on both sides. A one-sided surface is written only if its material is black, or where no
  path meets its back (``scenes.backs``).
- It tells the sides by the shading normal alone, ours is black where the two normals disagree: silhouettes differ.
- Its textures are filtered over the footprint of a pixel, and its mirrors have a Fresnel reflectance.
- Its environment maps are constant in each pixel of an equal-area square, ours bilinear in latitude and longitude.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.backs import visible_backs
from scenes.formats import export
from scenes.formats.export import Export, Source, UnsupportedFeatureError, kind
from scenes.formats.ply import ply
from scenes.lights import AreaLight, ConstantEnvironment, DirectionalLight, Light, PointLight, SpotLight
from scenes.materials import (
    Blend,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
    Mirror,
    RoughConductor,
    RoughDielectric,
)
from scenes.scene import Scene
from scenes.sensor import Orthographic, Pinhole, Sensor, ThinLens
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]

FORMAT = "pbrt-v4"
_COLOURS = ("radiance", "intensity", "irradiance")


def pbrt_v4(scene: Scene, name: str = "scene", source: Source = export.UNKNOWN) -> Export:
    """The scene as text, with its meshes (PLY).

    Args:
        scene: with one channel or three.
        name: what the names of the other files and of the image begin with.
        source: for the header.

    Raises:
        UnsupportedFeatureError: naming what pbrt does not have, or means differently.
    """
    export.refuse_spectra(FORMAT, scene)
    _refuse_backs(scene)
    lines, files = _Writer(export.portable(name)).write(scene, source.bounces)
    lines = [*(f"# {line}" for line in _header(scene, source, name)), "", *lines]
    return Export(("\n".join(lines) + "\n").encode(), files)


def _header(scene: Scene, source: Source, name: str) -> list[str]:
    usage = [f"Bounces 0 to {source.bounces}: pbrt --spp 256 {name}.pbrt, or edit maxdepth below for others"]
    if any(min(values) != max(values) for values in _emitted(scene)):
        usage.append(
            "Coloured lights: pbrt's fit misses their channels by up to about 0.2 %; export one --channel at a time"
        )
    return export.header(scene, source, *usage)


def _emitted(scene: Scene) -> Iterator[tuple[float, ...]]:
    """The colours of all that emits."""
    for part in (*scene.surfaces, *scene.lights):
        emission = part.emission if isinstance(part, Surface) else part
        if emission is not None:
            yield from (getattr(emission, f) for f in _COLOURS if f in emission.__struct_fields__)


def _unsupported(feature: str) -> UnsupportedFeatureError:
    return UnsupportedFeatureError(FORMAT, feature)


def _refuse_backs(scene: Scene) -> None:
    surfaces = {surface.name: surface for surface in scene.surfaces}
    for name in visible_backs(scene):
        if not _is_black(surfaces[name].material):
            raise _unsupported(
                f"the back of {name} may be seen: here it is black, in pbrt it reflects as the front does; "
                "close the body, or make the surface black or two-sided"
            )


def _is_black(material: Material) -> bool:
    return (
        isinstance(material, Lambertian) and isinstance(material.albedo, tuple) and not any(material.albedo)
    )


# ---- directives


def _numbers(values: ArrayLike) -> str:
    """All digits: reading them gives the same numbers."""
    return " ".join(repr(float(value)) for value in np.ravel(values))


def _floats(name: str, values: ArrayLike) -> str:
    return f'"float {name}" [ {_numbers(values)} ]'


def _integers(name: str, values: Iterable[int]) -> str:
    return f'"integer {name}" [ {" ".join(map(str, values))} ]'


def _points(name: str, values: ArrayLike) -> str:
    return f'"point3 {name}" [ {_numbers(values)} ]'


def _string(name: str, value: str) -> str:
    return f'"string {name}" [ "{value}" ]'


def _bool(name: str, value: bool) -> str:
    return f'"bool {name}" [ {str(value).lower()} ]'


def _rgb(name: str, values: tuple[float, ...]) -> str:
    return f'"rgb {name}" [ {_numbers(export.rgb(values))} ]'


def _grey(field: str, values: tuple[float, ...]) -> float:
    """The one number that all channels have."""
    if min(values) != max(values):
        raise _unsupported(
            f"coloured {field} {tuple(values)}: pbrt's are spectra, whose products are no products per channel; "
            "export one channel at a time (--channel)"
        )
    return values[0]


def _spectrum(name: str, values: tuple[float, ...]) -> str:
    """The same at all wavelengths."""
    value = _grey(name, values)
    return f'"spectrum {name}" [ {_numbers([200, value, 1000, value])} ]'


def _transform(axes: ArrayLike, center: ArrayLike) -> str:
    """Where the local x, y and z axis and the local origin go; pbrt's matrix runs column by column."""
    columns = np.zeros((4, 4))
    columns[:3, :3], columns[3, :3], columns[3, 3] = axes, center, 1
    return f"Transform [ {_numbers(columns)} ]"


# ---- the scene


class _Writer:
    """Collects the files and the named materials that the text refers to."""

    def __init__(self, name: str) -> None:
        self._name, self._files, self._parts = name, dict[str, bytes](), 0

    def write(self, scene: Scene, bounces: int) -> tuple[list[str], dict[str, bytes]]:
        lines = [
            *_sensor(scene.sensor),
            f"Film {self._film(scene.sensor)}",
            f"PixelFilter {_plugin('box')} {_floats('xradius', 0.5)} {_floats('yradius', 0.5)}",
            f"Sampler {_plugin('independent')} {_integers('pixelsamples', [64])}",
            "# maxdepth = n holds bounces 0 to n",
            f"Integrator {_plugin('path')} {_integers('maxdepth', [bounces])}",
            "",
            "WorldBegin",
        ]
        for light in scene.lights:
            lines.append(_light(light))
        for surface in scene.surfaces:
            lines += ["", *self._surface(surface)]
        return lines, self._files

    def _film(self, sensor: Sensor) -> str:
        size = f"{_integers('xresolution', [sensor.width])} {_integers('yresolution', [sensor.height])}"
        return (
            f"{_plugin('rgb')} {size} {_string('filename', f'{self._name}.exr')} {_bool('savefp16', False)}"
        )

    def _surface(self, surface: Surface) -> list[str]:
        *parts, material = self._material(surface.material)
        lines = ["AttributeBegin", *(f"  {part}" for part in parts), f"  Material {material}"]
        if surface.emission is not None and surface.emits:
            lines.append(f"  {_area_light(surface, surface.emission)}")
        lines += [f"  {line}" for line in self._shape(surface)]
        return [*lines, "AttributeEnd"]

    def _shape(self, surface: Surface) -> list[str]:
        shape = surface.shape
        match shape:
            case Quad():
                c, u, v = map(np.asarray, (shape.corner, shape.edge_u, shape.edge_v))
                corners = np.stack([c, c + u, c + u + v, c + v])
                indices = _integers("indices", [0, 1, 2, 0, 2, 3])
                return [f"Shape {_plugin('trianglemesh')} {_points('P', corners)} {indices}"]
            case Disk():
                return _disk(surface, shape)
            case Sphere() | Ellipsoid():
                return _ellipsoid(surface, shape)
            case Mesh():
                if shape.normals is not None:
                    raise _unsupported(
                        f"shading normals of {surface.name}: where they disagree with the triangles about the side, "
                        "here it is black, in pbrt it reflects; leave them out"
                    )
                file = f"{self._name}-{len(self._files)}.ply"
                self._files[file] = ply(shape)
                return [f"Shape {_plugin('plymesh')} {_string('filename', file)}"]

    def _material(self, material: Material) -> list[str]:
        """Its type and its parameters; before it the directives that name its parts."""
        match material:
            case Lambertian():
                if not isinstance(material.albedo, tuple):
                    raise _unsupported(
                        f"{kind(material.albedo)} texture: pbrt filters it over a pixel's footprint"
                    )
                albedo = _grey("albedo", material.albedo)
                return [f"{_plugin('diffuse')} {_rgb('reflectance', (albedo,))}"]
            case Mirror():
                raise _unsupported("mirror: pbrt's conductor reflects more towards grazing angles")
            case Dielectric() | RoughDielectric():
                eta = material.interior_ior / material.exterior_ior
                return [f"{_plugin('dielectric')} {_floats('eta', eta)} {_roughness(material)}"]
            case Conductor() | RoughConductor():
                index = f"{_spectrum('eta', material.eta)} {_spectrum('k', material.k)}"
                return [f"{_plugin('conductor')} {index} {_roughness(material)}"]
            case Blend():
                first, one = self._named(material.first)
                second, other = self._named(material.second)
                names = f'"string materials" [ "{one}" "{other}" ]'
                return [*first, *second, f"{_plugin('mix')} {names} {_floats('amount', material.weight)}"]

    def _named(self, material: Material) -> tuple[list[str], str]:
        """The directives that give it a name which no other material of the scene has, and that name."""
        *parts, made = self._material(material)
        kind_, _, parameters = made.partition(" ")
        name, self._parts = f"part{self._parts}", self._parts + 1
        return [*parts, f'MakeNamedMaterial "{name}" "string type" [ {kind_} ] {parameters}'], name


def _plugin(name: str) -> str:
    return f'"{name}"'


# ---- shapes


def _disk(surface: Surface, disk: Disk) -> list[str]:
    u, v = np.asarray(disk.axis_u), np.asarray(disk.axis_v)
    length = float(np.linalg.norm(u))
    if abs(u @ v) > 1e-9 * length**2 or abs(np.linalg.norm(v) - length) > 1e-9 * length:
        if surface.emits:
            raise _unsupported(
                f"{surface.name} is an ellipse that emits: pbrt samples it as if it were round"
            )
        return [
            _transform([u, v, disk.normal], disk.center),
            f"Shape {_plugin('disk')} {_floats('radius', 1)}",
        ]
    axes = [u / length, v / length, disk.normal]
    return [_transform(axes, disk.center), f"Shape {_plugin('disk')} {_floats('radius', length)}"]


def _ellipsoid(surface: Surface, shape: Sphere | Ellipsoid) -> list[str]:
    reverse = ["ReverseOrientation"] if shape.inward else []
    if isinstance(shape, Sphere):
        placed, radius = _transform(np.eye(3), shape.center), shape.radius
    else:
        if surface.emits:
            raise _unsupported(
                f"{surface.name} is an ellipsoid that emits: pbrt samples it as if it were round"
            )
        axes, radius = shape.matrix.T, 1.0
        if np.linalg.det(axes) < 0:  # the same points, and no turning over of normals
            axes = axes * [[1], [1], [-1]]
        placed = _transform(axes, shape.center)
    return [*reverse, placed, f"Shape {_plugin('sphere')} {_floats('radius', radius)}"]


# ---- materials and lights


def _roughness(material: Dielectric | RoughDielectric | Conductor | RoughConductor) -> str:
    if isinstance(material, Dielectric | Conductor):
        return _floats("roughness", 0)
    if material.shadowing != "correlated":
        raise _unsupported(f"{material.shadowing} shadowing: pbrt's is the correlated one")
    return f"{_floats('roughness', material.alpha)} {_bool('remaproughness', False)}"


def _area_light(surface: Surface, light: AreaLight) -> str:
    if light.polar_range is not None:
        raise _unsupported(f"{surface.name} emits from a zone: pbrt's area light is a whole shape")
    if light.angular_profile is not None:
        raise _unsupported(f"{surface.name} has an angular profile: pbrt's area light is diffuse")
    radiance = _rgb("L", light.radiance)
    return f"AreaLightSource {_plugin('diffuse')} {radiance} {_bool('twosided', surface.two_sided)}"


def _light(light: Light) -> str:
    match light:
        case PointLight():
            return f"LightSource {_plugin('point')} {_points('from', light.position)} {_rgb('I', light.intensity)}"
        case SpotLight():
            if light.beam != light.cutoff:
                raise _unsupported(
                    f"a spot that falls off between {light.beam:g}° and {light.cutoff:g}°: here linearly in the "
                    "angle, in pbrt smoothly in its cosine"
                )
            target = np.add(light.position, light.direction)
            place = f"{_points('from', light.position)} {_points('to', target)}"
            cone = f"{_floats('coneangle', light.cutoff)} {_floats('conedeltaangle', 0)}"
            return f"LightSource {_plugin('spot')} {place} {cone} {_rgb('I', light.intensity)}"
        case DirectionalLight():
            place = f"{_points('from', (0, 0, 0))} {_points('to', light.direction)}"
            return f"LightSource {_plugin('distant')} {place} {_rgb('L', light.irradiance)}"
        case ConstantEnvironment():
            return f"LightSource {_plugin('infinite')} {_rgb('L', light.radiance)}"
        case _:
            raise _unsupported(
                f"{kind(light)} light: pbrt's environment is an equal-area square, constant in each of its pixels"
            )


# ---- sensors


def _sensor(sensor: Sensor) -> list[str]:
    if not isinstance(sensor, Pinhole | ThinLens | Orthographic):
        raise _unsupported(f"{kind(sensor)}: pbrt has cameras only")
    view = [
        "Scale -1 1 1",
        f"LookAt {_numbers(sensor.origin)}  {_numbers(sensor.target)}  {_numbers(sensor.up)}",
    ]
    if isinstance(sensor, Orthographic):
        half = np.array([sensor.width, sensor.height]) * sensor.extent / 2 / min(sensor.width, sensor.height)
        window = _floats("screenwindow", [-half[0], half[0], -half[1], half[1]])
        return [*view, f"Camera {_plugin('orthographic')} {window}"]
    lens = ""
    if isinstance(sensor, ThinLens):
        lens = f" {_floats('lensradius', sensor.aperture_radius)}"
        lens += f" {_floats('focaldistance', sensor.focus_distance)}"
    return [*view, f"Camera {_plugin('perspective')} {_floats('fov', sensor.fov)}{lens}"]
