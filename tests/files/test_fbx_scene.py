"""FBX scenes built by hand: units, axes, scale, pivots, layers, choice of take and of joints."""

import itertools

import numpy as np
import pytest

from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.rotation import euler_to_quat, quat_distance, quat_to_matrix
from kinestitch.errors import FormatError, KinestitchWarning
from kinestitch.files.fbx import list_takes, read_fbx
from kinestitch.files.fbx.binary import serialise
from kinestitch.files.fbx.build import node, numbers, properties, ticks_of, vector
from kinestitch.files.fbx.nodes import Document

SHORT = {"T": "Lcl Translation", "R": "Lcl Rotation", "S": "Lcl Scaling"}


class Build:
    """An FBX document under construction."""

    def __init__(self, **settings):
        self.settings = settings
        self.objects, self.links, self.key = [], [], 100

    def add(self, kind, name, label, *children):
        self.key += 1
        self.objects.append(node(kind, "LSS", self.key, f"{name}\x00\x01{kind}", label, children=children))
        return self.key

    def link(self, child, parent, name=""):
        row = ("C", "SLLS", "OP", child, parent, name) if name else ("C", "SLL", "OO", child, parent)
        self.links.append(node(*row))

    def model(self, name, parent=0, kind="LimbNode", t=(0, 0, 0), r=(0, 0, 0), s=(1, 1, 1), numbers=None, **vectors):
        entries = [
            vector(SHORT["T"], t, SHORT["T"]),
            vector(SHORT["R"], r, SHORT["R"]),
            vector(SHORT["S"], s, SHORT["S"]),
        ]
        entries += [vector(label, values) for label, values in vectors.items()]
        plain = {"RotationActive": 1, "InheritType": 1, **(numbers or {})}
        entries += [(label, "enum", "", "", [value]) for label, value in plain.items()]
        key = self.add("Model", name, kind, properties(*entries))
        self.link(key, parent)
        return key

    def take(self, name="Take 001"):
        return self.add("AnimationStack", name, "")

    def layer(self, take, **values):
        entries = [(label, "double", "Number", "", [float(value)]) for label, value in values.items()]
        key = self.add("AnimationLayer", "Layer", "", properties(*entries))
        self.link(key, take)
        return key

    def animate(self, layer, model, what, values, fps=30.0, flags=4, times=None):
        group = self.add("AnimationCurveNode", what, "")
        self.link(group, layer)
        self.link(group, model, SHORT[what])
        values = np.asarray(values, dtype=float)
        times = ticks_of(len(values), fps) if times is None else np.asarray(times)
        for axis, column in zip("XYZ", values.T, strict=True):
            curve = self.add(
                "AnimationCurve", "", "", numbers("KeyTime", "l", times), numbers("KeyValueFloat", "f", column),
                numbers("KeyAttrFlags", "i", np.array([flags])), numbers("KeyAttrDataFloat", "f", np.zeros(4)),
                numbers("KeyAttrRefCount", "i", np.array([len(times)])),
            )  # fmt: skip
            self.link(curve, group, f"d|{axis}")

    def read(self, path, **options):
        types = {float: "double", int: "int"}
        entries = [(name, types[type(value)], "", "", [value]) for name, value in self.settings.items()]
        tree = [
            node("GlobalSettings", children=[properties(*entries)]),
            node("Objects", children=self.objects),
            node("Connections", children=self.links),
        ]
        path.write_bytes(serialise(Document(7400, tuple(tree))))
        return read_fbx(path, **options)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scene.fbx"


def test_an_armature_with_scale_and_a_turn_is_baked(path):
    build = Build(UnitScaleFactor=100.0)
    armature = build.model("Armature", kind="Null", t=(1, 2, 3), r=(-90, 0, 0), s=(0.01, 0.01, 0.01))
    hips = build.model("Hips", armature, t=(0, 0, 100), r=(0, 0, 30))
    build.model("Knee", hips, t=(0, 50, 0), r=(20, 0, 0))
    build.animate(build.layer(build.take()), hips, "R", [[0, 0, 30], [0, 0, 60], [0, 0, 90]])
    motion = build.read(path)
    assert motion.skeleton.names == ("Hips", "Knee")
    pose = world_pose(motion)
    np.testing.assert_allclose(pose.positions[:, 0], [[1, 3, 3]] * 3, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(motion.translations[:, 1], axis=-1), 0.5)
    np.testing.assert_allclose(pose.positions[2, 1], [0.5, 3, 3], atol=1e-6)
    assert quat_distance(motion.rotations[:, 1], euler_to_quat(np.radians([20, 0, 0]), "XYZ")).max() < 1e-9
    assert (motion.translations[:, 1] == motion.translations[0, 1]).all()


@pytest.mark.parametrize(("up", "front", "coord"), list(itertools.permutations(range(3))), ids=lambda axis: "xyz"[axis])
def test_every_system_of_axes_lands_upright(up, front, coord, path):
    for signs in itertools.product((1, -1), repeat=3):
        names = ("UpAxis", "FrontAxis", "CoordAxis")
        settings = dict(zip(names, (up, front, coord), strict=True))
        settings |= {f"{name}Sign": sign for name, sign in zip(names, signs, strict=True)}
        build = Build(**settings)
        high, near, right = (np.eye(3)[axis] * sign * 100 for axis, sign in zip((up, front, coord), signs, strict=True))
        root = build.model("Root", t=tuple(high), r=(10, 20, 30))
        build.model("Near", root, t=(3, 4, 5), r=(40, 50, 60))
        build.model("Right", root, t=tuple(right))
        motion = build.read(path)
        pose = world_pose(motion)
        np.testing.assert_allclose(pose.positions[0, 0], [0, 1, 0], atol=1e-12)
        # the file's own world, told along right, up and near
        turn = quat_to_matrix(euler_to_quat(np.radians([30, 20, 10]), "ZYX"))
        basis = np.stack([right, high, near]) / 100
        expected = [[0, 1, 0], basis @ (high + turn @ [3, 4, 5]) / 100, basis @ (high + turn @ right) / 100]
        np.testing.assert_allclose(pose.positions[0], expected, atol=1e-9)
        np.testing.assert_allclose(rest_pose(motion.skeleton)[0], expected, atol=1e-9)


@pytest.mark.parametrize(("unit", "metres"), [(1.0, 0.01), (100.0, 1.0), (2.54, 0.0254), (0.0, 0.01), (-1.0, 0.01)])
def test_units(unit, metres, path):
    build = Build(UnitScaleFactor=unit)
    build.model("Root", t=(1, 2, 3))
    np.testing.assert_allclose(build.read(path).translations[0, 0], np.array([1, 2, 3]) * metres)


def test_pivots_turn_about_themselves(path):
    build = Build(UnitScaleFactor=100.0)
    root = build.model("Root", t=(1, 0, 0), r=(0, 0, 90), RotationPivot=(0, 1, 0), RotationOffset=(0, 0, 5))
    build.model("Tip", root, t=(0, 3, 0))
    pose = world_pose(build.read(path))
    # the pivot (0, 1, 0) stays where it is; the origin swings about it, and the tip with it
    np.testing.assert_allclose(pose.positions[0], [[2, 1, 5], [-1, 1, 5]], atol=1e-12)


def test_post_rotation_and_the_inactive_flag(path):
    build = Build()
    build.model("Root", r=(10, 0, 0), PreRotation=(0, 0, 90), PostRotation=(0, 0, 90))
    turned = build.read(path).rotations[0, 0]
    assert quat_distance(turned, euler_to_quat(np.radians([0, 10, 0]), "XYZ")) < 1e-9
    build = Build()
    build.model("Root", r=(10, 0, 0), PreRotation=(0, 0, 90), numbers={"RotationActive": 0})
    assert quat_distance(build.read(path).rotations[0, 0], euler_to_quat(np.radians([10, 0, 0]), "XYZ")) < 1e-9


@pytest.mark.parametrize(("inherit", "x"), [(0, 1 + 6), (1, 1 + 6), (2, 1 + 3)])
def test_ways_to_inherit_scale(inherit, x, path):
    build = Build(UnitScaleFactor=100.0)
    root = build.model("Root", s=(2, 2, 2))
    middle = build.model("Middle", root, t=(0.5, 0, 0), numbers={"InheritType": inherit})
    build.model("Tip", middle, t=(3, 0, 0))
    np.testing.assert_allclose(world_pose(build.read(path)).positions[0, 2], [x, 0, 0])


def test_the_stack_that_moves_wins_and_mixamo_beats_all(path):
    build = Build(TimeMode=6)
    root = build.model("Root")
    build.layer(build.take("Take 001"))
    build.animate(build.layer(build.take("long")), root, "T", np.ones((9, 3)))
    build.animate(build.layer(build.take("short")), root, "T", np.ones((4, 3)))
    assert build.read(path).frames == 9
    assert build.read(path, take="short").frames == 4
    assert build.read(path, take="Take 001").frames == 1
    build.animate(build.layer(build.take("mixamo.com")), root, "T", np.ones((5, 3)))
    assert build.read(path).frames == 5
    assert list_takes(path) == ("Take 001", "long", "short", "mixamo.com")


@pytest.mark.parametrize(
    ("mode", "keys", "frames", "fps"),
    [(6, 30, 10, 30), (6, 24, 10, 24), (6, 60, 10, 60), (3, 30, 19, 60), (6, 30000 / 1001, 10, 30000 / 1001)],
)
def test_keys_that_stand_evenly_at_another_rate_win(mode, keys, frames, fps, path):
    build = Build(TimeMode=mode)
    build.animate(build.layer(build.take()), build.model("Root"), "T", np.arange(30).reshape(10, 3), fps=keys)
    motion = build.read(path)
    assert (motion.frames, motion.fps) == (frames, fps)


def test_frames_between_keys(path):
    build = Build(TimeMode=6)
    layer = build.layer(build.take())
    steps, root = build.model("Steps"), build.model("Later")
    values = np.array([[0, 0, 0], [6, 6, 6], [0, 0, 0]])
    times = ticks_of(13, 30)[[0, 3, 12]]
    build.animate(layer, steps, "T", values, times=times, flags=2)
    build.animate(layer, root, "T", values, times=times)
    motion = build.read(path)
    assert motion.skeleton.names == ("Root", "Steps", "Later")
    assert motion.frames == 13
    np.testing.assert_allclose(motion.translations[:, 1, 0] * 100, [0, 0, 0] + [6] * 9 + [0])
    np.testing.assert_allclose(
        motion.translations[:, 2, 0] * 100, np.interp(range(13), [0, 3, 12], [0, 6, 0]), atol=1e-9
    )


@pytest.mark.parametrize(
    ("mode", "weight", "expected"), [(0, 100, 30.0), (0, 50, 20.0), (1, 50, 20.0), (2, 50, 15.0), (2, 100, 20.0)]
)
def test_layers_add_and_override(mode, weight, expected, path):
    build = Build(TimeMode=6)
    take, root = build.take(), build.model("Root")
    build.animate(build.layer(take), root, "T", np.full((3, 3), 10.0))
    build.animate(build.layer(take, BlendMode=mode, Weight=weight), root, "T", np.full((3, 3), 20.0))
    np.testing.assert_allclose(build.read(path).translations[:, 0] * 100, expected)


def test_without_bones_what_moves_is_a_joint(path):
    build = Build()
    build.model("Camera", kind="Camera")
    group = build.model("Group", kind="Null", t=(0, 100, 0))
    box = build.model("Box", group, kind="Mesh", t=(100, 0, 0))
    build.model("Still", group, kind="Mesh")
    with pytest.raises(FormatError, match="neither"):
        build.read(path)
    build.animate(build.layer(build.take()), box, "R", np.ones((3, 3)))
    motion = build.read(path)
    assert motion.skeleton.names == ("Group", "Box")
    np.testing.assert_allclose(motion.translations[0], [[0, 1, 0], [1, 0, 0]])


def test_several_roots_get_one_above_them(path):
    build = Build()
    rig = build.model("Rig", kind="Null", t=(0, 0, 100))
    build.model("Left", rig, t=(100, 0, 0))
    build.model("Right", rig, t=(-100, 0, 0))
    motion = build.read(path)
    assert motion.skeleton.names == ("Rig", "Left", "Right")
    np.testing.assert_allclose(world_pose(motion).positions[0], [[0, 0, 1], [1, 0, 1], [-1, 0, 1]])
    build.model("Elsewhere", t=(0, 100, 0), s=(2, 2, 2))
    motion = build.read(path)
    assert motion.skeleton.names == ("Root", "Left", "Right", "Elsewhere")
    np.testing.assert_allclose(world_pose(motion).positions[0, 1:], [[1, 0, 1], [-1, 0, 1], [0, 1, 0]])


def test_names_that_stand_twice_are_numbered_with_one_warning(path):
    build = Build()
    root = build.model("Bone")
    build.model("Bone", root)
    build.model("Bone.001", root)
    with pytest.warns(KinestitchWarning, match="1 joint name"):
        assert len(set(build.read(path).skeleton.names)) == 3


def test_the_bind_pose_is_the_rest_pose(path):
    build = Build()
    root = build.model("Root", t=(0, 90, 0), r=(0, 45, 0))
    tip = build.model("Tip", root, t=(0, 10, 0), r=(45, 0, 0))
    world = [np.eye(4), np.eye(4)]
    world[0][3, 1], world[1][3, :2] = 100, (20, 100)
    entries = [
        node("PoseNode", children=[node("Node", "L", key), numbers("Matrix", "d", matrix.ravel())])
        for key, matrix in zip((root, tip), world, strict=True)
    ]
    build.add("Pose", "Bind", "BindPose", *entries)
    skeleton = build.read(path).skeleton
    np.testing.assert_allclose(skeleton.offsets, [[0, 1, 0], [0.2, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(skeleton.rest, [[0, 0, 0, 1]] * 2, atol=1e-12)


def test_a_circle_of_models_is_refused(path):
    build = Build()
    first = build.model("First")
    second = build.model("Second", first)
    build.links = build.links[1:]
    build.link(first, second)
    with pytest.raises(FormatError, match="circle"):
        build.read(path)


def test_two_keys_an_age_apart_are_refused(path):
    build = Build()
    build.animate(build.layer(build.take()), build.model("Root"), "T", np.ones((2, 3)), times=[0, 2**61])
    with pytest.raises(FormatError, match="frames"):
        build.read(path)
