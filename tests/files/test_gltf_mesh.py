"""The surface of a glTF character, against the formula of the format's own specification."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

import numpy as np
import pytest

from kinestitch.errors import FormatError
from kinestitch.files import read, write
from kinestitch.files.gltf_document import load_document
from kinestitch.files.gltf_figure import open_figure
from kinestitch.files.gltf_mesh import read_mesh
from kinestitch.files.gltf_rest import inverse_bind_matrices
from kinestitch.files.gltf_scene import worlds
from kinestitch.render.skinned import Character
from kinestitch.samples import sample

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)


@pytest.fixture(scope="module")
def characters():
    spec = importlib.util.spec_from_file_location("gltf_character", Path(__file__).parent / "gltf_character.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def by_the_specification(path, frame, joints, shares, points):
    """Σ share · joint matrix · inverse bind matrix · point, at one frame of the file's animation."""
    document = load_document(path)
    figure = open_figure(document, None)
    inverse = inverse_bind_matrices(document, len(figure.parents))
    places = worlds(
        document, figure.parents, figure.joints, figure.take, times=figure.times[[frame]], frame=1 / figure.fps
    )
    total = np.zeros((len(points), 3))
    for joint, share in zip(joints, shares, strict=True):
        node = document.objects("skins")[0]["joints"][joint]
        bound = points @ inverse[node][:3, :3].T + inverse[node][:3, 3]
        total += share * (bound @ places[node].linear[0].T + places[node].position[0])
    return total


@pytest.mark.parametrize("frame", [0, 7, 19])
def test_posed_as_the_specification_says(characters, tmp_path, frame):
    path = characters.plain_character().save(tmp_path / "a.glb")
    mesh, motion = read_mesh(path), read(path)
    assert mesh.skeleton == motion.skeleton
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    expected = by_the_specification(path, frame, (0, 1), (0.5, 0.5), POINTS)
    vertices, _ = Character(mesh).posed(motion, frame)
    assert np.abs(vertices - expected).max() < 1e-5 * np.abs(expected).max()


def test_colours_and_normals(characters, tmp_path):
    character = characters.plain_character()
    character.document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.2, 0.0, 1.0]}}]
    mesh = read_mesh(character.save(tmp_path / "a.glb"))
    assert mesh.colours[0] == pytest.approx([1.0, 0.4845, 0.0], abs=1e-3)  # sRGB
    a, b, c = mesh.vertices
    face = np.cross(b - a, c - a)
    assert np.allclose(mesh.normals, face / np.linalg.norm(face))


def test_a_vertex_without_weights_stays_with_the_first_joint(characters, tmp_path):
    character = characters.plain_character()
    part = character.document["meshes"][0]["primitives"][0]
    part["attributes"]["WEIGHTS_0"] = character.add([[0, 0, 0, 0], [2, 2, 0, 0], [1, 0, 0, 0]], "VEC4")
    weights = read_mesh(character.save(tmp_path / "a.glb")).weights
    assert weights[:, :2].tolist() == [[1, 0], [0.5, 0.5], [1, 0]]


@pytest.mark.parametrize(
    ("attribute", "values", "kind", "dtype", "words"),
    [
        ("JOINTS_0", [[9, 0, 0, 0]] * 3, "VEC4", "|u1", "joints from 0 to 5"),
        ("JOINTS_0", [[0, 0, 0, 0]] * 2, "VEC4", "|u1", "3 vertices"),
        ("POSITION", [[np.inf, 0, 0]] * 3, "VEC3", "<f4", "finite"),
    ],
)
def test_damaged_meshes_are_refused(characters, tmp_path, attribute, values, kind, dtype, words):
    character = characters.plain_character()
    part = character.document["meshes"][0]["primitives"][0]
    index = character.add(values, kind, dtype)
    character.document["accessors"][index] |= {"min": [0], "max": [0]}
    part["attributes"][attribute] = index
    path = character.save(tmp_path / "a.glb") if attribute != "POSITION" else save_infinite(character, tmp_path)
    with pytest.raises(FormatError, match=words):
        read_mesh(path)


def save_infinite(character, folder):
    for entry in character.document["accessors"]:
        for bound in ("min", "max"):
            entry[bound] = [0]
    return character.save(folder / "a.glb")


def test_indices_beyond_the_vertices_are_refused(characters, tmp_path):
    character = characters.plain_character()
    part = character.document["meshes"][0]["primitives"][0]
    part["indices"] = character.add([0, 1, 3], "SCALAR", "<u2")
    with pytest.raises(FormatError, match="indices from 0 to 2"):
        read_mesh(character.save(tmp_path / "a.glb"))


def test_a_skeleton_alone_is_refused(tmp_path):
    write(sample("idle"), tmp_path / "a.glb")
    with pytest.raises(FormatError, match="mesh with a skin"):
        read_mesh(tmp_path / "a.glb")


@pytest.mark.parametrize(("name", "triangles"), [("Michelle", 28106), ("Xbot", 49112), ("Soldier", 11376)])
def test_real_characters(name, triangles):
    folder = os.environ.get("KINESTITCH_DATA")
    if not folder:
        pytest.skip("KINESTITCH_DATA, the folder of real clips, is not set")
    mesh = read_mesh(Path(folder) / "mixamo_skinned" / f"{name}.glb")
    assert mesh.triangles.shape == (triangles, 3)
    assert np.ptp(mesh.vertices[:, 1]) == pytest.approx(1.75, abs=0.1)  # m tall, on its feet
    assert abs(mesh.vertices[:, 1].min()) < 0.01
    corners = mesh.vertices[mesh.triangles]
    volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert 0.03 < volume < 0.15  # m³, outside out
