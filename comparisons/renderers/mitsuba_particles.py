"""What Mitsuba's ``ptracer`` can't see: it connects every point of a particle's path to the camera.

Through a delta lobe there is one direction only, and chance never finds the camera in it. What such a surface
reflects or refracts into the camera is missing from the image, and nothing else is.
"""

from __future__ import annotations

from comparisons.renderers.protocol import Unsupported
from scenes import (
    Blend,
    Conductor,
    Dielectric,
    Material,
    Mirror,
    Pinhole,
    Scene,
    ThinLens,
)


def refuse_what_particles_cannot_reach(scene: Scene) -> None:
    """Refuse scenes in which light may reach the camera where no particle can be connected to it.

    Raises:
        Unsupported: naming the feature.
    """
    if not isinstance(scene.sensor, Pinhole | ThinLens):
        tag = scene.sensor.__struct_config__.tag
        raise Unsupported(f"{tag} sensor: a particle of ptracer can't be connected to it")
    for surface in scene.surfaces:
        for part in _parts(surface.material):
            if isinstance(part, Mirror | Dielectric | Conductor):
                tag = part.__struct_config__.tag
                raise Unsupported(
                    f"{tag} material: a particle of ptracer on it can't be connected to the camera"
                )


def _parts(material: Material) -> list[Material]:
    if isinstance(material, Blend):
        return [*_parts(material.first), *_parts(material.second)]
    return [material]
