"""Another motion in an FBX file whose character is kept; the files are built here, node by node."""

import contextlib
from dataclasses import replace

import numpy as np
import pytest

import kinestitch.files
from kinestitch.core.kinematics import with_joint_axes, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance, quat_multiply, quat_normalize, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError, SkeletonMismatchError
from kinestitch.files.fbx import has_character_fbx, list_takes, read_fbx, write_fbx
from kinestitch.files.fbx.binary import parse_binary, serialise
from kinestitch.files.fbx.build import (
    curve_keys,
    definitions,
    documents,
    header,
    node,
    numbers,
    properties,
    settings,
    takes,
    ticks_of,
    vector,
)
from kinestitch.files.fbx.curves import TICKS
from kinestitch.files.fbx.nodes import Document
from kinestitch.files.fbx.parts import Parts
from kinestitch.testing import assert_motion_close, random_motion

SHORT = {"T": "Lcl Translation", "R": "Lcl Rotation", "S": "Lcl Scaling"}
ANIMATION = {"AnimationCurve", "AnimationCurveNode", "AnimationLayer", "AnimationStack"}


class Character:
    """A file under construction: an armature of scale 100 that moves, three awkward bones, a mesh with a skin, a
    material with a texture, a shape that moves, and two takes.
    """

    def __init__(self):
        self.parts = Parts()
        self.models = {}
        self.model("Armature", "Null", t=(1, 2, 3), r=(-90, 0, 0), s=(100, 100, 100))
        self.model("Hips", "LimbNode", "Armature", t=(0, 0.9, 0), order=3, PreRotation=(10, 20, 30))
        pivots = {"PostRotation": (5, 0, 9), "RotationPivot": (0.1, 0.2, 0), "RotationOffset": (0, 0.3, 0.1)}
        self.model("Spine", "LimbNode", "Hips", t=(0, 0.2, 0.02), order=5, inherit=1, **pivots)
        self.model("Head", "LimbNode", "Spine", t=(0, 0.3, 0), s=(1.5, 1.5, 1.5), inherit=2, ScalingPivot=(0, 0.1, 0))
        self.flesh()
        self.stacks = {name: self.stack(name) for name in ("Walk", "Wave")}
        for name, frames in (("Wave", 5), ("Walk", 12)):
            self.animate(name, "Hips", "T", np.linspace([0, 0.9, 0], [0, 0.9, 1], frames))
            self.animate(name, "Hips", "R", np.linspace([0, 0, 0], [0, 80, 10], frames))
            self.animate(name, "Spine", "R", np.linspace([0, 0, 0], [30, 0, 10], frames))
            self.animate(name, "Armature", "T", np.linspace([1, 2, 3], [1, 2, 9], frames))
            self.animate(name, "Head", "S", np.linspace([1.5, 1.5, 1.5], [2, 2, 2], frames))

    def model(self, name, kind, above=None, t=(0, 0, 0), r=(0, 0, 0), s=(1, 1, 1), order=0, inherit=0, **vectors):
        entries = [vector(SHORT[k], v, SHORT[k]) for k, v in zip("TRS", (t, r, s), strict=True)]
        entries += [vector(label, values) for label, values in vectors.items()]
        plain = {"RotationActive": 1, "RotationOrder": order, "InheritType": inherit}
        entries += [(label, "enum", "", "", [value]) for label, value in plain.items()]
        self.models[name] = self.parts.add("Model", name, kind, [properties(*entries)])
        self.parts.link(self.models[name], self.models.get(above, 0))

    def flesh(self):
        rng = np.random.default_rng(0)
        shape = [numbers("Vertices", "d", rng.normal(size=300)), numbers("PolygonVertexIndex", "i", np.arange(100))]
        mesh = self.parts.add("Geometry", "Skin", "Mesh", shape)
        self.model("Body", "Mesh")
        self.parts.link(mesh, self.models["Body"])
        skin = self.parts.add("Deformer", "", "Skin", [node("Link_DeformAcuracy", "D", 50.0)])
        self.parts.link(skin, mesh)
        for name in ("Hips", "Spine"):
            weights = [numbers("Indexes", "i", np.arange(50)), numbers("Weights", "d", rng.uniform(size=50))]
            cluster = self.parts.add("Deformer", "", "Cluster", weights)
            self.parts.link(cluster, skin)
            self.parts.link(self.models[name], cluster)
        paint = self.parts.add("Material", "Paint", "", [node("ShadingModel", "S", "phong")])
        picture = self.parts.add("Video", "Picture", "Clip", [node("Content", "R", rng.bytes(1000))])
        self.parts.link(paint, self.models["Body"])
        self.parts.link(picture, paint, "DiffuseColor")
        self.smile = self.parts.add("Deformer", "Smile", "BlendShapeChannel", [node("DeformPercent", "D", 10.0)])

    def stack(self, name):
        key = self.parts.add("AnimationStack", name, "", [properties()])
        return key, [self.layer(key)]

    def layer(self, stack, **values):
        entries = [(label, "double", "Number", "", [float(value)]) for label, value in values.items()]
        key = self.parts.add("AnimationLayer", "Base", "", [properties(*entries)])
        self.parts.link(key, stack)
        return key

    def animate(self, take, model, what, values, layer=0, key=None, start=0):
        group = self.parts.add("AnimationCurveNode", what, "", [])
        self.parts.link(group, self.stacks[take][1][layer])
        self.parts.link(group, self.models[model] if key is None else key, SHORT.get(what, what))
        for axis, column in zip("XYZ", np.asarray(values, dtype=float).T, strict=False):
            keys = curve_keys(start + ticks_of(len(column), 30.0), column)
            self.parts.link(self.parts.add("AnimationCurve", "", "", keys), group, f"d|{axis}")
        return group

    def document(self, version=7400):
        stop = 2 * TICKS
        nodes = [
            *header(),
            settings(30.0, stop),
            *documents(7, "Walk"),
            definitions(self.parts.objects),
            node("Objects", children=self.parts.objects),
            node("Connections", children=self.parts.links),
            takes("Walk", stop),
        ]
        return Document(version, tuple(nodes))

    def save(self, path, version=7400):
        path.write_bytes(serialise(self.document(version)))
        return path


@pytest.fixture
def character(tmp_path):
    return Character().save(tmp_path / "character.fbx")


def another(motion, frames=30, fps=30.0):
    """A motion of the same skeleton that goes far round in every joint."""
    rng = np.random.default_rng(frames)
    time = np.arange(frames)[:, None, None] / fps
    joints = motion.skeleton.joint_count
    swing = rng.normal(size=(joints, 3)) * 1.5 * np.sin(3 * time + rng.uniform(0, 6, size=(joints, 3)))
    translations = np.repeat(motion.translations[:1], frames, axis=0) + 0.1 * np.sin(time)
    rotations = quat_normalize(quat_multiply(motion.rotations[:1], rotvec_to_quat(swing)))
    return replace(motion, translations=translations, rotations=rotations, fps=fps)


def encoded(entry, wide=False):
    return serialise(Document(7500 if wide else 7400, (entry,)))


def objects_of(path):
    return {entry.properties[0]: entry for entry in parse_binary(path.read_bytes()).child("Objects").children}


@pytest.mark.parametrize("fps", [30.0, 24.0, 60.0, 29.97, 37.3])
@pytest.mark.parametrize("frames", [1, 2, 7, 50])
def test_reading_gives_the_motion_back(character, tmp_path, fps, frames):
    motion = another(read_fbx(character), frames, fps)
    fewer = pytest.warns(KinestitchWarning, match=r"'Walk'.*'Wave'") if frames < 5 else contextlib.nullcontext()
    with fewer:
        kinestitch.files.write(motion, tmp_path / "new.fbx", like=character)
    again = read_fbx(tmp_path / "new.fbx", take="Walk")
    assert again.skeleton == motion.skeleton
    assert_motion_close(again, motion, degrees=1e-3, metres=1e-5)
    assert_motion_close(again, motion, metres=1e-4, world=True)


def test_everything_outside_the_animation_is_kept_byte_for_byte(character, tmp_path):
    write_fbx(another(read_fbx(character)), tmp_path / "new.fbx", like=character)
    old, new = objects_of(character), objects_of(tmp_path / "new.fbx")
    kept = [key for key, entry in old.items() if entry.name not in ANIMATION]
    assert len(kept) == 12
    assert [key for key, entry in new.items() if entry.name not in ANIMATION] == kept
    assert all(encoded(old[key]) == encoded(new[key]) for key in kept)
    before, after = (parse_binary(path.read_bytes()) for path in (character, tmp_path / "new.fbx"))
    for one, other in zip(before.nodes, after.nodes, strict=True):
        if one.name not in {"Objects", "Connections", "Definitions", "GlobalSettings", "Takes"}:
            assert encoded(one) == encoded(other)
    one, other = (
        {(n.text(), *n.properties[1:]): n for n in tree.child("Connections").children} for tree in (before, after)
    )
    assert one.keys() <= other.keys()


def test_the_other_take_is_kept_byte_for_byte(character, tmp_path):
    before = read_fbx(character, take="Wave")
    write_fbx(another(read_fbx(character)), tmp_path / "new.fbx", like=character)
    assert list_takes(tmp_path / "new.fbx") == ("Walk", "Wave")
    assert_motion_close(read_fbx(tmp_path / "new.fbx", take="Wave"), before, degrees=1e-12, metres=1e-15)
    old, new = objects_of(character), objects_of(tmp_path / "new.fbx")
    same = [key for key in old if encoded(old[key]) == encoded(new[key])]
    assert sum(old[key].name == "AnimationCurve" for key in same) == 15


def test_counts_lengths_and_the_rate_are_told(character, tmp_path):
    write_fbx(another(read_fbx(character), 91, 60.0), tmp_path / "new.fbx", like=character)
    tree = parse_binary((tmp_path / "new.fbx").read_bytes())
    objects = [entry.name for entry in tree.child("Objects").children]
    told = tree.child("Definitions")
    counts = {entry.text(): entry.child("Count").integer() for entry in told.all("ObjectType")}
    assert {name: objects.count(name) for name in set(objects)} == {
        name: count for name, count in counts.items() if name != "GlobalSettings"
    }
    assert told.child("Count").integer() == sum(counts.values())
    assert len({entry.properties[0] for entry in tree.child("Objects").children}) == len(objects)
    said = {p.text(): p.properties[4] for p in tree.child("GlobalSettings").child("Properties70").children}
    assert (said["TimeMode"], said["TimeSpanStop"]) == (3, 90 * TICKS // 60)
    take = tree.child("Takes").child("Take")
    assert take.child("LocalTime").properties == (0, 90 * TICKS // 60)
    stack = next(entry for entry in tree.child("Objects").children if entry.name == "AnimationStack")
    spans = {p.text(): p.properties[4] for p in stack.child("Properties70").children}
    assert spans == {"LocalStart": 0, "LocalStop": 90 * TICKS // 60, "ReferenceStart": 0,
                     "ReferenceStop": 90 * TICKS // 60}  # fmt: skip


def test_writing_what_was_written_changes_nothing(character, tmp_path):
    write_fbx(another(read_fbx(character)), tmp_path / "a.fbx", like=character)
    write_fbx(read_fbx(tmp_path / "a.fbx"), tmp_path / "b.fbx", like=tmp_path / "a.fbx")
    assert_motion_close(read_fbx(tmp_path / "b.fbx"), read_fbx(tmp_path / "a.fbx"), degrees=1e-5, metres=1e-7)
    motion = read_fbx(tmp_path / "b.fbx")
    write_fbx(motion, tmp_path / "b.fbx", like=tmp_path / "b.fbx")
    assert_motion_close(read_fbx(tmp_path / "b.fbx"), motion, degrees=1e-5, metres=1e-7)


@pytest.mark.parametrize("version", [7100, 7400, 7500, 7700])
def test_the_version_stays(tmp_path, version):
    path = Character().save(tmp_path / "a.fbx", version)
    write_fbx(another(read_fbx(path)), tmp_path / "b.fbx", like=path)
    assert parse_binary((tmp_path / "b.fbx").read_bytes()).version == version


def test_other_layers_let_go_of_the_joints_only(tmp_path):
    made = Character()
    made.stacks["Walk"][1].append(made.layer(made.stacks["Walk"][0], Weight=50))
    over = made.animate("Walk", "Spine", "R", np.full((3, 3), 20.0), layer=1)
    smile = made.animate("Walk", "", "DeformPercent", np.full((3, 1), 60.0), layer=1, key=made.smile)
    path = made.save(tmp_path / "a.fbx")
    motion = another(read_fbx(path))
    write_fbx(motion, tmp_path / "b.fbx", like=path)
    assert_motion_close(read_fbx(tmp_path / "b.fbx"), motion, degrees=1e-3, metres=1e-5)
    left = objects_of(tmp_path / "b.fbx")
    assert smile in left
    assert over not in left


def test_a_curve_that_drives_two_joints_is_taken_apart(tmp_path):
    made = Character()
    both = made.animate("Walk", "Spine", "T", np.full((4, 3), 0.1))
    made.parts.link(both, made.models["Head"], SHORT["T"])
    path = made.save(tmp_path / "a.fbx")
    motion = another(read_fbx(path))
    write_fbx(motion, tmp_path / "b.fbx", like=path)
    assert_motion_close(read_fbx(tmp_path / "b.fbx"), motion, degrees=1e-3, metres=1e-5)


def test_a_curve_that_two_takes_share_is_refused_by_name(tmp_path):
    made = Character()
    shared = made.animate("Walk", "Spine", "T", np.full((4, 3), 0.1))
    made.parts.link(shared, made.stacks["Wave"][1][0])
    path = made.save(tmp_path / "a.fbx")
    with pytest.raises(FormatError, match=r"'Spine'.*a\.fbx\)$"):
        write_fbx(another(read_fbx(path)), tmp_path / "b.fbx", like=path)


def test_the_take_keeps_its_start(tmp_path):
    made = Character()
    made.stacks["Late"] = made.stack("Late")
    made.animate("Late", "Hips", "R", np.linspace([0, 0, 0], [0, 80, 10], 40), start=TICKS)
    path = made.save(tmp_path / "a.fbx")
    write_fbx(another(read_fbx(path)), tmp_path / "b.fbx", like=path, take="Late")
    assert read_fbx(tmp_path / "b.fbx").frames == 30
    keys = [
        e.child("KeyTime").integers() for e in objects_of(tmp_path / "b.fbx").values() if e.name == "AnimationCurve"
    ]
    assert sum(times[0] == TICKS and len(times) == 30 for times in keys) >= 3


def test_a_file_without_takes_gets_one(tmp_path):
    made = Character()
    gone = {entry.properties[0] for entry in made.parts.objects if entry.name in ANIMATION}
    made.parts.objects = [entry for entry in made.parts.objects if entry.properties[0] not in gone]
    made.parts.links = [entry for entry in made.parts.links if not gone & set(entry.properties[1:3])]
    path = made.save(tmp_path / "a.fbx")
    motion = another(read_fbx(path))
    write_fbx(motion, tmp_path / "b.fbx", like=path, take="Kick")
    assert list_takes(tmp_path / "b.fbx") == ("Kick",)
    assert_motion_close(read_fbx(tmp_path / "b.fbx"), motion, degrees=1e-3, metres=1e-5)


def test_joints_are_matched_by_name_whatever_prefix_and_axes(character, tmp_path):
    motion = another(read_fbx(character))
    names = tuple(f"mixamorig8:{name}" for name in motion.skeleton.names)
    other = with_joint_axes(replace(motion, skeleton=replace(motion.skeleton, names=names)), [0.0, 0.0, 0.0, 1.0])
    write_fbx(other, tmp_path / "new.fbx", like=character)
    assert_motion_close(read_fbx(tmp_path / "new.fbx"), motion, degrees=1e-3, metres=1e-5)


def test_joints_that_the_motion_lacks_keep_their_rest(character, tmp_path):
    motion = another(read_fbx(character))
    whole = motion.skeleton
    part = Skeleton(whole.names[:2], whole.parents[:2], whole.offsets[:2], whole.rest[:2])
    less = Motion(part, motion.translations[:, :2], motion.rotations[:, :2], motion.fps)
    write_fbx(less, tmp_path / "new.fbx", like=character)
    again = read_fbx(tmp_path / "new.fbx")
    assert np.abs(world_pose(again).positions[:, :2] - world_pose(motion).positions[:, :2]).max() < 1e-4
    assert np.degrees(quat_distance(again.rotations[:, 2], whole.rest[2])).max() < 1e-3


def test_a_joint_that_the_file_lacks_is_named(character, tmp_path):
    motion = read_fbx(character)
    names = (*motion.skeleton.names[:-1], "Tail")
    with pytest.raises(SkeletonMismatchError, match=r"'Tail'.*character\.fbx\)$"):
        write_fbx(replace(motion, skeleton=replace(motion.skeleton, names=names)), tmp_path / "b.fbx", like=character)
    assert not (tmp_path / "b.fbx").exists()


def test_what_cannot_be_kept_is_refused(character, tmp_path):
    motion = read_fbx(character)
    with pytest.raises(ParameterError, match=r"'Walk', 'Wave', got 'Run'.*character\.fbx\)$"):
        write_fbx(motion, tmp_path / "b.fbx", like=character, take="Run")
    text = tmp_path / "text.fbx"
    text.write_text("; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n\tFBXVersion: 7400\n}\n")
    with pytest.raises(FormatError, match=r"binary FBX 7.*text.*text\.fbx\)$"):
        write_fbx(motion, tmp_path / "b.fbx", like=text)
    old = Character().save(tmp_path / "old.fbx", 6100)
    with pytest.raises(FormatError, match="older"):
        write_fbx(motion, tmp_path / "b.fbx", like=old)
    with pytest.raises(ParameterError, match="like="):
        kinestitch.files.write(motion, tmp_path / "b.bvh", like=character)
    with pytest.raises(FileNotFoundError):
        write_fbx(motion, tmp_path / "b.fbx", like=tmp_path / "none.fbx")


def test_scale_of_nothing_is_refused(tmp_path):
    made = Character()
    made.model("Flat", "LimbNode", "Hips", s=(1, 0, 1), inherit=1)
    made.model("Hand", "LimbNode", "Flat", t=(0, 1, 0), inherit=1)
    path = made.save(tmp_path / "a.fbx")
    with pytest.raises(FormatError, match=r"scale.*Bake"):
        write_fbx(another(read_fbx(path)), tmp_path / "b.fbx", like=path)


def test_a_character_is_a_mesh(character, tmp_path):
    assert has_character_fbx(character)
    assert kinestitch.files.has_character(character)
    write_fbx(random_motion(1), tmp_path / "bones.fbx")
    assert not has_character_fbx(tmp_path / "bones.fbx")
    text = tmp_path / "text.fbx"
    text.write_text('; FBX 7.4.0 project file\nObjects:  {\n\tGeometry: 1, "", "Mesh" {\n\t\tVertices: *3 {\n')
    assert has_character_fbx(text)
    (tmp_path / "cut.fbx").write_bytes(character.read_bytes()[:5000])
    assert not kinestitch.files.has_character(tmp_path / "cut.fbx")


def test_writing_is_the_same_every_time(character, tmp_path):
    motion = another(read_fbx(character))
    for name in ("a.fbx", "b.fbx"):
        write_fbx(motion, tmp_path / name, like=character)
    assert (tmp_path / "a.fbx").read_bytes() == (tmp_path / "b.fbx").read_bytes()
