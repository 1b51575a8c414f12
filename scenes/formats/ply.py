"""Triangle meshes as PLY: binary, little-endian, coordinates in double precision, so that nothing is rounded."""

from __future__ import annotations

import numpy as np

from scenes.shapes import Mesh


def ply(mesh: Mesh) -> bytes:
    """The content of the file: vertices with their normals and texture coordinates, if any, and triangles."""
    columns = {"x y z": mesh.vertices, "nx ny nz": mesh.normals, "u v": mesh.uv}
    present = {names: values for names, values in columns.items() if values is not None}
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(mesh.vertices)}",
        *(f"property double {name}" for names in present for name in names.split()),
        f"element face {len(mesh.triangles)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    vertices = np.concatenate([np.asarray(values, dtype="<f8") for values in present.values()], axis=1)
    faces = np.empty(len(mesh.triangles), dtype=[("count", "u1"), ("indices", "<i4", 3)])
    faces["count"], faces["indices"] = 3, mesh.triangles
    return "\n".join(header).encode() + b"\n" + vertices.tobytes() + faces.tobytes()
