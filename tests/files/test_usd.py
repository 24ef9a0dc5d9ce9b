"""USD: written and read back, read from text made here, compared with UsdSkel's own evaluation, and damaged."""

import os
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinestitch import files
from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.rotation import quat_distance, rotvec_to_quat
from kinestitch.errors import (
    FormatError,
    KinestitchError,
    KinestitchWarning,
    MissingExtraError,
    OutputError,
    ParameterError,
    UnsupportedFormatError,
)
from kinestitch.files.isolated import Isolated
from kinestitch.files.usd import list_takes, read_usd, write_usd
from kinestitch.testing import assert_motion_close, check_motion, random_motion

pytest.importorskip("pxr.Usd", reason="usd-core, of the extra usd, is not installed")
DATA = os.environ.get("KINESTITCH_DATA")

SCENE = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
    timeCodesPerSecond = 24
)
def SkelRoot "Body" {
    def Skeleton "Rig" (prepend apiSchemas = ["SkelBindingAPI"]) {
        uniform token[] joints = ["Hip", "Hip/Knee", "Hip/Knee/Foot"]
        uniform matrix4d[] restTransforms = [
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,1,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,-0.5,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,-0.4,0,1))]
        uniform matrix4d[] bindTransforms = [
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,1,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0.5,0,1)),
            ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0.1,0,1))]
        rel skel:animationSource = </Body/Rig/Walk>
        def SkelAnimation "Walk" {
            uniform token[] joints = ["Hip/Knee"]
            float3[] translations = [(0,-0.5,0)]
            quatf[] rotations.timeSamples = { 0: [(1,0,0,0)], 2: [(0.70710678,0.70710678,0,0)] }
            half3[] scales = [(1,1,1)]
        }
        def SkelAnimation "Wave" {
            uniform token[] joints = ["Hip", "Hip/Knee", "Hip/Knee/Foot"]
            float3[] translations.timeSamples = {
                0: [(0,1,0),(0,-0.5,0),(0,-0.4,0)], 12: [(0,2,0),(0,-0.5,0),(0,-0.4,0)] }
            quatf[] rotations = [(1,0,0,0),(1,0,0,0),(1,0,0,0)]
            half3[] scales = [(1,1,1),(1,1,1),(1,1,1)]
        }
    }
}
"""


def read(folder, text=SCENE, **options):
    (folder / "scene.usda").write_text(text)
    return read_usd(folder / "scene.usda", **options)


def test_the_bound_animation_on_the_rest_pose(tmp_path):
    motion = read(tmp_path)
    check_motion(motion)
    assert motion.skeleton.names == ("Hip", "Knee", "Foot")
    assert (motion.frames, motion.fps, motion.name) == (3, 24.0, "Walk")
    np.testing.assert_allclose(motion.skeleton.offsets, [[0, 1, 0], [0, -0.5, 0], [0, -0.4, 0]], atol=1e-12)
    angles = np.pi / 4 * np.arange(3)
    turned = rotvec_to_quat(np.stack([angles, 0 * angles, 0 * angles], axis=-1))
    assert np.degrees(quat_distance(motion.rotations[:, 1], turned)).max() < 1e-4
    np.testing.assert_allclose(world_pose(motion).positions[2, 2], [0, 0.5, -0.4], atol=1e-6)


def test_takes(tmp_path):
    wave = read(tmp_path, take="Wave")
    assert list_takes(tmp_path / "scene.usda") == ("Walk", "Wave")
    assert (wave.frames, wave.name) == (13, "Wave")
    np.testing.assert_allclose(wave.translations[6, 0], [0, 1.5, 0])
    with pytest.raises(ParameterError, match=r"\('Walk', 'Wave'\), got 'Run'"):
        read(tmp_path, take="Run")


def test_without_a_binding_the_animation_of_most_joints_is_taken(tmp_path):
    assert read(tmp_path, SCENE.replace("rel skel:", "rel other:")).name == "Wave"


def test_a_skeleton_without_animation_is_one_frame(tmp_path):
    text = SCENE[: SCENE.index("rel skel")] + "}\n}\n"
    motion = read(tmp_path, text)
    assert (motion.frames, motion.name) == (1, "scene")
    assert list_takes(tmp_path / "scene.usda") == ()
    np.testing.assert_allclose(motion.translations[0], motion.skeleton.offsets)


def test_axes_and_units(tmp_path):
    text = SCENE.replace('upAxis = "Y"', 'upAxis = "Z"').replace("metersPerUnit = 1", "metersPerUnit = 0.01")
    motion = read(tmp_path, text)
    np.testing.assert_allclose(
        world_pose(motion).positions[0], [[0, 0, -0.01], [0, 0, -0.005], [0, 0, -0.001]], atol=1e-9
    )
    assert np.abs(motion.rotations[0, 0]).tolist() == pytest.approx([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    places, _ = rest_pose(motion.skeleton)
    np.testing.assert_allclose(places[0], [0, 0, -0.01], atol=1e-12)


def test_transforms_above_are_part_of_the_roots_motion(tmp_path):
    moving = """def SkelRoot "Body" {
    double3 xformOp:translate.timeSamples = { 0: (0,0,0), 4: (4,0,0) }
    double3 xformOp:scale = (2,2,2)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]"""
    motion = read(tmp_path, SCENE.replace('def SkelRoot "Body" {', moving))
    assert motion.frames == 5
    np.testing.assert_allclose(world_pose(motion).positions[2, 0], [2, 2, 0])
    np.testing.assert_allclose(np.linalg.norm(motion.translations[:, 1], axis=-1), 1.0)


@pytest.mark.parametrize(
    ("codes", "samples", "fps", "frames"),
    [
        (24, (0, 1, 2, 3), 24, 4),
        (60, (0, 2, 4, 6), 60, 7),
        (24, (0, 0.4, 0.8, 1.2), 60, 4),
        (24, (0, 24), 24, 25),
        (24, (1, 2.5, 4), 48, 7),
        (24, (1, 2.5, 3), 48, 5),
        (4800, (0, 160, 320, 480), 30, 4),
        (24, (7,), 24, 1),
        (29.97003, (5, 6, 8), 30000 / 1001, 4),
    ],
)
def test_frames(tmp_path, codes, samples, fps, frames):
    keys = ", ".join(f"{time}: [(1,0,0,0)]" for time in samples)
    text = SCENE.replace("0: [(1,0,0,0)], 2: [(0.70710678,0.70710678,0,0)]", keys)
    motion = read(tmp_path, text.replace("timeCodesPerSecond = 24", f"timeCodesPerSecond = {codes}"))
    assert motion.frames == frames
    assert motion.fps == pytest.approx(fps, rel=1e-4)


def test_the_stages_range_adds_frames_that_stand_still(tmp_path):
    ranged = SCENE.replace("upAxis", "startTimeCode = -2\n    endTimeCode = 5\n    upAxis")
    assert read(tmp_path, ranged).frames == 3  # of two animations one may be shorter than the stage
    alone = ranged[: ranged.index('def SkelAnimation "Wave"')] + "}\n}\n"
    motion = read(tmp_path, alone)
    assert motion.frames == 8
    np.testing.assert_array_equal(motion.rotations[:2], motion.rotations[[2, 2]])
    np.testing.assert_array_equal(motion.rotations[5:], motion.rotations[[4, 4, 4]])
    for bounds in ("1e300", "nan", "-7"):
        assert read(tmp_path, alone.replace("endTimeCode = 5", f"endTimeCode = {bounds}")).frames in (3, 5)


def test_names_are_jointnames_else_parts_of_paths(tmp_path):
    named = SCENE.replace(
        "uniform matrix4d[] rest", 'uniform token[] jointNames = ["mix:Hip", "b", "c"]\nuniform matrix4d[] rest', 1
    )
    assert read(tmp_path, named).skeleton.names == ("mix:Hip", "b", "c")
    short = named.replace('"b", "c"]', '"b"]')
    assert read(tmp_path, short).skeleton.names == ("Hip", "Knee", "Foot")
    with pytest.warns(KinestitchWarning, match=r"1 joint name\(s\) used twice"):
        assert read(tmp_path, SCENE.replace("/Foot", "/Hip")).skeleton.names == ("Hip", "Knee", "Hip_2")


def test_several_roots_get_one_above_them(tmp_path):
    motion = read(tmp_path, SCENE.replace("Hip/Knee", "Knee"))
    assert motion.skeleton.names == ("Rig", "Hip", "Knee", "Foot")
    assert motion.skeleton.parents == (-1, 0, 0, 2)
    np.testing.assert_allclose(world_pose(motion).positions[0, 1:, 1], [1, -0.5, -0.9], atol=1e-7)


def test_children_before_their_parents_are_sorted(tmp_path):
    text = SCENE.replace('["Hip", "Hip/Knee", "Hip/Knee/Foot"]', '["Hip/Knee/Foot", "Hip/Knee", "Hip"]', 1)
    motion = read(tmp_path, text)
    assert motion.skeleton.names == ("Hip", "Knee", "Foot")
    np.testing.assert_allclose(motion.translations[0, :, 1], [-0.4, -0.5, 1.0], atol=1e-7)


def test_the_rest_pose_is_the_bind_pose_or_the_other_way_round(tmp_path):
    bound = SCENE.replace("(0,0.1,0,1)", "(0,0.2,0,1)")
    np.testing.assert_allclose(read(tmp_path, bound).skeleton.offsets[2], [0, -0.3, 0], atol=1e-12)
    only_rest = SCENE.replace("bindTransforms", "unusedTransforms")
    np.testing.assert_allclose(read(tmp_path, only_rest).skeleton.offsets[2], [0, -0.4, 0], atol=1e-12)
    only_bind = bound.replace("restTransforms", "unusedTransforms")
    np.testing.assert_allclose(read(tmp_path, only_bind).translations[0, 2], [0, -0.3, 0], atol=1e-7)
    flat = SCENE.replace("((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0.1,0,1))", "((0,0,0,0),(0,0,0,0),(0,0,0,0),(0,0.1,0,1))")
    np.testing.assert_allclose(read(tmp_path, flat).skeleton.offsets[2], [0, -0.4, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "Expected a file that the USD library can read"),
        ("#usda 1.0\n", "Expected a UsdSkel skeleton with joints, got no skeleton"),
        (SCENE.replace("joints = [", "jaunts = [", 1), r"got 1 skeleton\(s\) without joints"),
        (SCENE[: len(SCENE) // 2], "got: line 18:9: Expected }"),
        (SCENE.replace('"Hip/Knee/Foot"]', '"Hip/Knee"]', 1), "joints of different paths in /Body/Rig"),
        (SCENE.replace("metersPerUnit = 1", "metersPerUnit = 0"), "metersPerUnit between"),
        (SCENE.replace("timeCodesPerSecond = 24", "timeCodesPerSecond = -1"), "timeCodesPerSecond between"),
        (SCENE.replace("(0,-0.5,0)]", "(0,inf,0)]"), "Expected finite translations in 'Walk'"),
        (SCENE.replace("(0,-0.5,0)]", "(0,1,0),(0,1,0)]"), "Expected 1 translations of 3 numbers in 'Walk'"),
        (SCENE.replace("2: [(0.70710678,0.70710678,0,0)]", "2e9: [(1,0,0,0)]"), "Expected up to .* frames, got"),
        (
            SCENE.replace("Transforms", "Transfers"),
            "Expected restTransforms or bindTransforms of 3 joints, got neither",
        ),
    ],
)
def test_damaged_text(tmp_path, text, message, capfd):
    with pytest.raises(FormatError, match=message) as caught:
        read(tmp_path, text)
    assert str(caught.value).endswith("scene.usda)")
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_missing_file_and_a_missing_library(tmp_path, monkeypatch):
    with pytest.raises(FileNotFoundError):
        files.read(tmp_path / "none.usda")
    monkeypatch.setitem(sys.modules, "pxr.Usd", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'kinestitch\[usd\]'"):
        read(tmp_path)
    monkeypatch.setitem(sys.modules, "pxr.UsdUtils", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'kinestitch\[usd\]'"):
        write_usd(random_motion(0), tmp_path / "a.usda")
    assert not (tmp_path / "a.usda").exists()


def test_nothing_is_printed_of_references_that_lead_nowhere(tmp_path, capfd):
    read(tmp_path, SCENE + 'def "Other" (references = @./none.usda@) {}\n')
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
@pytest.mark.parametrize("unit", ["m", "cm"])
def test_there_and_back(tmp_path, suffix, unit):
    motion = random_motion(7, joints=12, frames=30)
    files.write(motion, tmp_path / f"a{suffix}", unit=unit)
    again = files.read(tmp_path / f"a{suffix}")
    assert_motion_close(again, motion, degrees=1e-4, metres=1e-6)
    np.testing.assert_allclose(again.skeleton.offsets, motion.skeleton.offsets, atol=1e-9)
    assert quat_distance(again.skeleton.rest, motion.skeleton.rest).max() < 1e-7


def test_names_and_rates_come_back(tmp_path):
    motion = random_motion(1, joints=5, frames=4, fps=30000 / 1001)
    names = ("mixamorig:Hips", "mixamorig_Hips", "1 arm", "Grüße/ß", "{}")
    motion = replace(motion, skeleton=replace(motion.skeleton, names=names), name="walk & kick")
    write_usd(motion, tmp_path / "a.usda")
    again = read_usd(tmp_path / "a.usda")
    assert again.skeleton.names == names
    assert again.fps == motion.fps
    text = (tmp_path / "a.usda").read_text(encoding="utf-8")
    assert '"mixamorig_Hips/mixamorig_Hips_2' in text
    assert "walk___kick" in text


def test_what_cannot_be_written(tmp_path):
    motion = random_motion(0)
    with pytest.raises(ParameterError, match="Expected a unit out of m, cm, got 'ft'"):
        write_usd(motion, tmp_path / "a.usda", unit="ft")
    with pytest.raises(OutputError):
        write_usd(motion, tmp_path / "none" / "a.usda")
    with pytest.raises(UnsupportedFormatError, match="read only"):
        files.write(motion, tmp_path / "a.usdz")


def test_a_package_is_read(tmp_path):
    from pxr import UsdUtils

    write_usd(random_motion(2), tmp_path / "a.usdc")
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "a.usdc"), str(tmp_path / "a.usdz"))
    assert_motion_close(files.read(tmp_path / "a.usdz"), random_motion(2), degrees=1e-4, metres=1e-6)


def evaluated(path):
    """World positions (F, J, 3) m that UsdSkel itself gives, one frame a time code, and the first sample's time."""
    from pxr import Usd, UsdGeom, UsdSkel

    stage = Usd.Stage.Open(str(path))
    prims = list(stage.Traverse())
    skeleton = next(UsdSkel.Skeleton(prim) for prim in prims if prim.IsA(UsdSkel.Skeleton))
    cache = UsdSkel.Cache()
    for prim in prims:
        if prim.IsA(UsdSkel.Root):
            cache.Populate(UsdSkel.Root(prim), Usd.TraverseInstanceProxies())
    query = cache.GetSkelQuery(skeleton)
    frames = []
    for code in np.arange(stage.GetStartTimeCode(), stage.GetEndTimeCode() + 1):
        matrices = query.ComputeJointWorldTransforms(UsdGeom.XformCache(Usd.TimeCode(code)))
        frames.append([tuple(matrix.ExtractTranslation()) for matrix in matrices])
    positions = np.array(frames) * UsdGeom.GetStageMetersPerUnit(stage)
    return positions if UsdGeom.GetStageUpAxis(stage) == "Y" else positions[..., [0, 2, 1]] * [1, 1, -1]


def test_usdskel_puts_our_joints_where_we_do(tmp_path):
    motion = random_motion(9, joints=15, frames=20)
    write_usd(motion, tmp_path / "a.usdc")
    np.testing.assert_allclose(evaluated(tmp_path / "a.usdc"), world_pose(motion).positions, atol=2e-6)


JOINTS = {
    "arm": (10, 3), "arm_baked": (10, 3), "dqs": (30, 3), "lbs": (30, 3), "root": (30, 3), "skeleton": (3, 66),
    "skinnedArm": (10, 3), "test_dqs": (120, 3), "test_lbs": (120, 3), "twoBends": (1, 4),
    "blendshapes": None, "blendshapesWithNormals": None, "populate": None,
}  # fmt: skip


def real():
    return sorted((Path(DATA) / "usd").iterdir()) if DATA else []


@pytest.mark.parametrize("path", real(), ids=lambda path: path.name)
def test_real_file(path, capfd):
    expected = JOINTS[path.stem]
    if expected is None:
        with pytest.raises(FormatError, match=r"got \d+ skeleton\(s\) without joints"):
            files.read(path)
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        motion = files.read(path)
    check_motion(motion)
    assert (motion.frames, motion.skeleton.joint_count, motion.fps) == (*expected, 24.0)
    positions = evaluated(path)
    np.testing.assert_allclose(world_pose(motion).positions, positions[: motion.frames], atol=1e-6)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_damage_raises_only_our_errors(tmp_path, suffix):
    """In a child process: on some damaged files the library crashes."""
    write_usd(random_motion(5, frames=6), tmp_path / f"good{suffix}")
    data = (tmp_path / f"good{suffix}").read_bytes()
    rng = np.random.default_rng(0)
    damaged, told = tmp_path / f"a{suffix}", []
    with Isolated(timeout=10) as reader, warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        for _ in range(80):
            content = bytearray(data[: rng.integers(1, len(data))] if rng.random() < 0.2 else data)
            for _ in range(rng.integers(1, 4)):
                content[rng.integers(len(content))] = rng.integers(256)
            damaged.write_bytes(content)
            try:
                check_motion(reader.read(damaged))
            except KinestitchError as error:
                told.append(str(error))
    assert all(text.endswith(")") for text in told)
