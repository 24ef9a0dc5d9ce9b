"""Which joint is the hips, where the legs begin, how high it all stands."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.hips import bare_name, hip_height, hip_line, hips_joint, leg_roots


def rig(text: str, offsets: dict[str, tuple[float, float, float]] | None = None) -> Skeleton:
    """``"Hips>Spine Hips>LeftLeg"``: joints in the order in which they are first named."""
    names: list[str] = []
    parents: list[int] = []
    for pair in text.split():
        parent, child = pair.split(">")
        if not names:
            names, parents = [parent], [-1]
        names.append(child)
        parents.append(names.index(parent))
    rows = [(offsets or {}).get(name, (0.0, 0.1, 0.0)) for name in names]
    return Skeleton(tuple(names), tuple(parents), np.array(rows))


@pytest.mark.parametrize(
    ("name", "bare"),
    [
        ("mixamorig:Hips", "Hips"),
        ("mixamorig8:Hips", "Hips"),
        ("mixamorig_Hips", "Hips"),
        ("mixamorig12_LeftArm.001", "LeftArm"),
        ("a:b:Hips", "Hips"),
        ("Hips", "Hips"),
        ("Spine.1", "Spine.1"),
    ],
)
def test_bare_names(name: str, bare: str):
    assert bare_name(name) == bare


@pytest.mark.parametrize("name", ["Hips", "mixamorig7:Hips", "hip", "pelvis", "Pelvis", "Bip01 Pelvis", "J_Bip_C_Hips"])
def test_hips_by_name_wherever_they_stand(name: str):
    assert hips_joint(rig(f"Root>Dummy Dummy>{name.replace(' ', '_')} Root>Camera")) == 2


def test_hips_where_legs_and_spine_part():
    tree = "Top>A A>Tail A>M M>L1 L1>L2 L2>L3 M>R1 R1>R2 R2>R3 M>S1 S1>S2 S2>S3"
    assert rig(tree).names[hips_joint(rig(tree))] == "M"
    fork = rig("Top>A A>L A>R")
    assert fork.names[hips_joint(fork)] == "A"
    assert hips_joint(rig("Top>A A>B")) == 0


LEGS = {
    "LeftUpLeg": (0.1, -0.05, 0.0),
    "RightUpLeg": (-0.1, -0.05, 0.0),
    "LeftLeg": (0.0, -0.42, 0.0),
    "RightLeg": (0.0, -0.42, 0.0),
    "LeftFoot": (0.0, -0.4, 0.0),
    "RightFoot": (0.0, -0.4, 0.0),
}
MIXAMO = (
    "Hips>Spine Hips>LeftUpLeg LeftUpLeg>LeftLeg LeftLeg>LeftFoot LeftFoot>LeftToeBase "
    "Hips>RightUpLeg RightUpLeg>RightLeg RightLeg>RightFoot RightFoot>RightToeBase"
)


def test_legs_and_height_of_a_plain_body():
    body = rig(MIXAMO, LEGS)
    assert [body.names[j] for j in leg_roots(body) or ()] == ["LeftUpLeg", "RightUpLeg"]
    assert hip_height(body) == pytest.approx(0.82)
    np.testing.assert_allclose(hip_line(body), [0.2, 0, 0])


def test_right_side_first_and_a_small_pair_beside_the_legs():
    text = (
        "Hips>RightPocket Hips>LeftPocket Hips>RightUpLeg RightUpLeg>RightLeg RightLeg>RightFoot "
        "Hips>LeftUpLeg LeftUpLeg>LeftLeg LeftLeg>LeftFoot"
    )
    body = rig(text, LEGS | {"LeftPocket": (0.2, 0, 0), "RightPocket": (-0.2, 0, 0)})
    assert [body.names[j] for j in leg_roots(body) or ()] == ["LeftUpLeg", "RightUpLeg"]


def test_hip_joints_that_stand_in_the_hips_are_passed_over():
    text = (
        "Hips>LHipJoint LHipJoint>LeftUpLeg LeftUpLeg>LeftLeg LeftLeg>LeftFoot "
        "Hips>RHipJoint RHipJoint>RightUpLeg RightUpLeg>RightLeg RightLeg>RightFoot"
    )
    nothing = (0.0, 0.0, 0.0)
    body = rig(text, LEGS | {"LHipJoint": nothing, "RHipJoint": nothing})
    assert [body.names[j] for j in leg_roots(body) or ()] == ["LeftUpLeg", "RightUpLeg"]
    assert hip_height(body) == pytest.approx(0.82)
    np.testing.assert_allclose(hip_line(body), [0.2, 0, 0])


def test_a_body_without_sides():
    body = rig("Hips>A A>B B>C")
    assert leg_roots(body) is None
    assert hip_line(body) is None
    assert hip_height(body) == pytest.approx(0.2)
    assert hip_height(Skeleton(("a",), (-1,), [[0, 0, 0]])) > 0


# Leg length in metres (hip joint to ankle), read off each file and plausible for its body.
REAL = [
    ("mixamo_xbot_30fps/Idle.fbx", "mixamorig:Hips", 0.889),
    ("mixamo_ybot_60fps/Idle.fbx", "mixamorig:Hips", 0.827),
    ("mixamo_prefix8/idle.fbx", "mixamorig8:Hips", 0.800),
    ("mixamo_other_rigs/fbx7400_Punching.fbx", "Hips", 0.765),
    ("mixamo_other_rigs/readyplayerme_Kicking.fbx", "Hips", 0.902),
    ("mixamo_other_rigs/zombie_idle.fbx", "Hips", 0.812),
    ("ue_mannequin/MCU_am_OrcHammer_Loco_Walk_Fwd.FBX", "pelvis", 0.856),
    ("bandai/dataset-1_walk_normal_001.bvh", "Hips", 0.801),
    ("cmu/02_01.bvh", "Hips", 0.843),
    ("cmu/131_01.bvh", "Hips", 0.802),
    ("cmu/16_15.bvh", "root", 0.836),
    ("conformance_bvh/test_mocapbank.bvh", "Hips", 0.876),
]


@pytest.mark.parametrize(("name", "hips", "height"), REAL)
def test_real_rigs(real_clip: Callable[[str], Motion], name: str, hips: str, height: float):
    motion = real_clip(name)
    body = motion.skeleton
    assert body.names[hips_joint(body)] == hips
    assert hip_height(body) == pytest.approx(height, abs=0.002)
    line = hip_line(body)
    assert line is not None
    assert 0.1 < np.linalg.norm(line) < 0.45
    standing = np.median(world_pose(motion).positions[:, hips_joint(body), 1])
    assert 0.85 * height < standing < 1.5 * height
