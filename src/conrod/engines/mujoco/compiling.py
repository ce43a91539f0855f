"""Compiling a model without seeking the convex hull of a mesh again that was met before.

MuJoCo seeks the hull of each mesh that can collide when a model is compiled: for a cam of 4000 vertices that takes a
second, several times what a coarse run of it takes. Of a mesh in a file MuJoCo keeps the hull, in a cache that lasts as
long as the process; then it takes 5 ms. So vertices that stand in a model's text are handed over as a file in memory.
The compiled model is the same to the last bit, but for the path of that file.
"""

from __future__ import annotations

import hashlib
import struct
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

# What else may stand beside vertices, and would have to be in the file too.
OTHER_PARTS = {"face", "normal", "texcoord", "file", "builtin"}


def compiled(text: str) -> mujoco.MjModel:
    """The model of an MJCF text.

    Raises:
        ValueError: MuJoCo cannot compile it.
    """
    root = ET.fromstring(text)
    files = {}
    for mesh in root.iterfind("asset/mesh"):
        if "vertex" in mesh.attrib and not OTHER_PARTS & set(mesh.attrib):
            content = _file_of(mesh.attrib.pop("vertex"))
            # Named after its content: whatever the cache compares, two meshes are never taken for one.
            name = f"{hashlib.sha256(content).hexdigest()}.msh"
            mesh.set("file", name)
            files[name] = content
    if not files:
        return mujoco.MjModel.from_xml_string(text)
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"), files)


def _file_of(vertices: str) -> bytes:
    """The vertices as a file in MuJoCo's MSH format: four counts, then single precision."""
    numbers = np.array(vertices.split(), dtype=np.float32)
    return struct.pack("4i", len(numbers) // 3, 0, 0, 0) + numbers.tobytes()
