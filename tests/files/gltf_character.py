"""A small character of our own with everything a glTF file can put in a writer's way."""

import base64
import json
import struct

import numpy as np

from kinestitch.files.glb import BINARY_CHUNK, serialise_glb
from kinestitch.files.gltf_writing import document_of
from kinestitch.testing import random_motion

UNKNOWN_CHUNK = 0x12345678
PICTURE = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


class Character:
    """A glTF document and its bytes while they are put together."""

    def __init__(self, *, joints=6, frames=20, seed=1):
        self.motion = random_motion(seed, joints=joints, frames=frames)
        self.document, pieces = document_of(self.motion)
        self.binary = bytearray(b"".join(pieces))
        self.document["animations"][0]["name"] = "first"
        self.joints = joints

    def add(self, values, kind, dtype="<f4", **more):
        data = np.ascontiguousarray(values, dtype=dtype)
        self.binary += b"\0" * (-len(self.binary) % 4)
        views = self.document["bufferViews"]
        views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": data.nbytes, **more})
        self.binary += data.tobytes()
        component = {"<f4": 5126, "<u2": 5123, "|u1": 5121}[dtype]
        entry = {"bufferView": len(views) - 1, "componentType": component, "count": len(data), "type": kind}
        flat = data.reshape(len(data), -1)
        entry |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        self.document["accessors"].append(entry)
        return len(self.document["accessors"]) - 1

    def node(self, **entry):
        self.document["nodes"].append(entry)
        return len(self.document["nodes"]) - 1

    def under(self, parent, **entry):
        """Put a new node above the roots of the scene's node `parent`."""
        index = self.node(children=[parent], **entry)
        roots = self.document["scenes"][0]["nodes"]
        roots[roots.index(parent)] = index
        return index

    def channel(self, node, path, times, values, *, animation=0, interpolation="LINEAR"):
        kind = {"rotation": "VEC4", "weights": "SCALAR"}.get(path, "VEC3")
        entry = self.document["animations"][animation]
        entry["channels"].append({"sampler": len(entry["samplers"]), "target": {"node": node, "path": path}})
        keys = {"input": self.add(times, "SCALAR"), "output": self.add(values, kind), "interpolation": interpolation}
        entry["samplers"].append(keys)

    def mesh(self):
        """A skinned triangle with a morph target, a material with a picture, and a camera."""
        where = self.add([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "VEC3", target=34962)
        moved = self.add([[0, 0, 0], [0, 0, 1], [0, 0, 0]], "VEC3", target=34962)
        joints = self.add([[0, 1, 0, 0]] * 3, "VEC4", "|u1", target=34962)
        weights = self.add([[0.5, 0.5, 0, 0]] * 3, "VEC4", target=34962)
        document = self.document
        texture = self.add([[0, 0], [1, 0], [0, 1]], "VEC2", target=34962)
        attributes = {"TEXCOORD_0": texture, "POSITION": where, "JOINTS_0": joints, "WEIGHTS_0": weights}
        part = {"attributes": attributes, "targets": [{"POSITION": moved}], "material": 0}
        document["meshes"] = [{"primitives": [part], "weights": [0.0], "extras": {"who": "us"}}]
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(PICTURE)}
        document["bufferViews"].append(view)
        self.binary += PICTURE
        document["images"] = [{"bufferView": len(document["bufferViews"]) - 1, "mimeType": "image/png"}]
        document["textures"] = [{"source": 0}]
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "name": "Größe"}]
        document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]
        face = self.node(name="face", mesh=0, skin=0)
        document["scenes"][0]["nodes"] += [face, self.node(name="eye", camera=0)]
        document["extras"] = {"note": [1.0, 1e-30, 3]}
        return face

    def save(self, path):
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.document["buffers"] = [{"byteLength": len(self.binary)}]
        if path.suffix == ".gltf":
            (path.parent / "data of it.bin").write_bytes(self.binary)
            self.document["buffers"][0]["uri"] = "data%20of%20it.bin"
            path.write_text(json.dumps(self.document))
        else:
            parts = [(BINARY_CHUNK, [bytes(self.binary)]), (UNKNOWN_CHUNK, [b"abcd"])]
            path.write_bytes(b"".join(serialise_glb(self.document, parts)))
        return path


def plain_character(**options):
    """An armature like those of many exporters: turned by −90° and a hundredth in size."""
    character = Character(**options)
    character.mesh()
    half = np.sqrt(0.5)
    character.under(0, name="Armature", rotation=[-half, 0, 0, half], scale=[0.01] * 3)
    return character


def awkward_character(**options):
    """Matrices, mirrors, uneven scales, keys on nodes above the joints, a node between joints, splines, strides."""
    character = Character(**options)
    face = character.mesh()
    nodes = character.document["nodes"]
    turn = np.array([[0, -2.0, 0, 1], [2.0, 0, 0, 2], [0, 0, 2.0, 3], [0, 0, 0, 1]])
    joint = nodes[2]
    x, y, z = joint.pop("translation")
    joint.pop("rotation")
    joint["matrix"] = [*turn[:, 0], *turn[:, 1], *turn[:, 2], x, y, z, 1]
    first = character.document["animations"][0]
    first["channels"] = [entry for entry in first["channels"] if entry["target"]["node"] != 2]
    nodes[1]["scale"] = [1.0, 1.3, 0.8]
    nodes[3]["scale"] = [-1.0, 1.0, 1.0]
    parent = next(i for i, node in enumerate(nodes) if 4 in node.get("children", []))
    nodes[parent]["children"].remove(4)
    nodes[parent]["children"].append(
        character.node(name="between", children=[4], rotation=[0, 1, 0, 0], scale=[3, 3, 3])
    )
    armature = character.under(0, name="Armature", matrix=[0.01, 0, 0, 0, 0, 0, -0.01, 0, 0, 0.01, 0, 0, 5, 6, 7, 1])
    carrier = character.under(armature, name="carrier", scale=[2, 2, 2])
    times = np.arange(5) / 30 + 0.1
    character.channel(carrier, "translation", times, np.arange(15).reshape(5, 3))
    character.channel(
        carrier, "rotation", times, [[0, 0, 0, 1], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    character.channel(5, "scale", times, np.linspace(1, 2, 15).reshape(5, 3))
    character.channel(face, "weights", times, np.linspace(0, 1, 15), interpolation="CUBICSPLINE")
    return character


def json_of(data):
    """The document of a GLB as its bytes say it, without our own reader."""
    (size,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + size])
