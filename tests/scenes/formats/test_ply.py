"""Another reader finds the mesh in the file."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
import trimesh

from scenes import Mesh, library
from scenes.formats.pfm import pfm
from scenes.formats.ply import ply

POINTS = ((0.0, 0.0, 0.0), (0.1, 0.0, 1 / 3), (0.0, 0.0, 0.3), (1e5, 1e-5, -7.0))
TRIANGLES = ((0, 1, 2), (3, 1, 0))
UP = ((0.0, -1.0, 0.0),) * 3
MESHES = {
    "flat": Mesh(POINTS, TRIANGLES),
    "with texture coordinates": Mesh(POINTS, TRIANGLES, uv=((0.1, 0.2),) * 4),
    "with normals": Mesh(POINTS[:3], ((0, 1, 2),), normals=UP),
    "with both": Mesh(POINTS[:3], ((0, 1, 2),), normals=UP, uv=((0.1, 0.2), (0.3, 0.4), (0.5, 0.6))),
    "of the library": library.case("furnace-mesh").scene.surfaces[0].shape,
}


@pytest.mark.parametrize("name", MESHES)
def test_a_mesh(name: str) -> None:
    mesh: Any = MESHES[name]
    found: Any = trimesh.load(io.BytesIO(ply(mesh)), file_type="ply", process=False)
    assert np.array_equal(found.vertices, mesh.vertices), "in double precision, nothing is rounded"
    assert np.array_equal(found.faces, mesh.triangles)
    if mesh.normals is not None:
        assert np.array_equal(found.vertex_normals, mesh.normals)
    if mesh.uv is not None:
        raw = found.metadata["_ply_raw"]["vertex"]["data"]
        assert np.array_equal(np.stack([raw["u"], raw["v"]], axis=-1).reshape(-1, 2), mesh.uv)


def test_a_picture() -> None:
    """The header is text, its rows run from the bottom to the top."""
    pixels = np.arange(2 * 5 * 3).reshape(2, 5, 3) / 7
    kind, size, scale, content = pfm(pixels).split(b"\n", 3)
    assert (kind, size, float(scale)) == (b"PF", b"5 2", -1)
    found = np.frombuffer(content, "<f4").reshape(2, 5, 3)
    assert np.array_equal(found[::-1], pixels.astype(np.float32))
