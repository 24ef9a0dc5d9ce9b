"""Text FBX, written by hand: what stands there is what comes out."""

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.rotation import euler_to_quat, quat_distance, quat_multiply
from kinestitch.errors import FormatError, ParameterError
from kinestitch.files.fbx import list_takes, read_fbx
from kinestitch.files.fbx.ascii import numbers, parse_ascii

SECOND = 46186158000
SEVEN = f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{
	FBXVersion: 7400
	Creator: "by hand; with a semicolon and a &quot;quote&quot;"
}}
GlobalSettings:  {{
	Properties70:  {{
		P: "UpAxis", "int", "Integer", "",2
		P: "FrontAxis", "int", "Integer", "",1
		P: "FrontAxisSign", "int", "Integer", "",-1
		P: "UnitScaleFactor", "double", "Number", "",100
		P: "TimeMode", "enum", "", "",11
	}}
}}
Definitions:  {{
	ObjectType: "Model" {{
		PropertyTemplate: "FbxNode" {{
			Properties70:  {{
				P: "RotationActive", "bool", "", "",1
				P: "InheritType", "enum", "", "",1
			}}
		}}
	}}
}}
Objects:  {{
	Model: 1, "Model::Hips", "LimbNode" {{
		Properties70:  {{
			P: "Lcl Translation", "Lcl Translation", "", "A",0,0,1
		}}
		Shading: Y
		Culling: "CullingOff"
	}}
	Model: 2, "Model::rig:Spine", "LimbNode" {{
		Properties70:  {{
			P: "PreRotation", "Vector3D", "Vector", "",90,0,0
			P: "RotationOrder", "enum", "", "",4
			P: "Lcl Translation", "Lcl Translation", "", "A",0,0,0.5
			P: "Lcl Rotation", "Lcl Rotation", "", "A",10,20,30
		}}
	}}
	AnimationStack: 10, "AnimStack::Take 001", "" {{
	}}
	AnimationLayer: 11, "AnimLayer::Base", "" {{
	}}
	AnimationCurveNode: 12, "AnimCurveNode::T", "" {{
		Properties70:  {{
			P: "d|X", "Number", "", "A",0
			P: "d|Y", "Number", "", "A",0
			P: "d|Z", "Number", "", "A",1
		}}
	}}
	AnimationCurve: 13, "AnimCurve::", "" {{
		KeyTime: *3 {{
			a: 0,{SECOND // 24},{SECOND // 6}
		}}
		KeyValueFloat: *3 {{
			a: 0,1e0,
4.0
		}}
		KeyAttrFlags: *1 {{
			a: 4
		}}
		KeyAttrDataFloat: *4 {{
			a: 0,0,0,0
		}}
		KeyAttrRefCount: *1 {{
			a: 3
		}}
	}}
}}
Connections:  {{
	;Model::Hips, Model::RootNode
	C: "OO",1,0
	C: "OO",2,1
	C: "OO",11,10
	C: "OO",12,11
	C: "OP",12,1, "Lcl Translation"
	C: "OP",13,12, "d|X"
}}
"""

SIX = f"""; FBX 6.1.0 project file
FBXHeaderExtension:  {{
	FBXVersion: 6100
}}
Objects:  {{
	Model: "Model::Root", "Root" {{
		Properties60:  {{
			Property: "Lcl Translation", "Lcl Translation", "A+",0,100,0
		}}
	}}
	Model: "Model::Limb", "Limb" {{
		Properties60:  {{
			Property: "Lcl Translation", "Lcl Translation", "A+",0,50,0
		}}
	}}
}}
Connections:  {{
	Connect: "OO", "Model::Root", "Model::Scene"
	Connect: "OO", "Model::Limb", "Model::Root"
}}
Takes:  {{
	Take: "Empty" {{
	}}
	Take: "Bow" {{
		Model: "Model::Limb" {{
			Channel: "Transform" {{
				Channel: "R" {{
					Channel: "X" {{
						Default: 0
						KeyVer: 4005
						KeyCount: 4
						Key: 0,0,L,{SECOND // 10},9,C,s,{SECOND // 5},30,U,s,0,0,n,
						{3 * SECOND // 10},60,U,s,-90,0,a,0.25,0.5
					}}
					Channel: "Y" {{
						Default: 5
					}}
				}}
			}}
		}}
	}}
}}
Version5:  {{
	Settings:  {{
		FrameRate: "20"
	}}
}}
"""


@pytest.fixture
def save(tmp_path):
    def write(text):
        path = tmp_path / "hand.fbx"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_seven(save):
    motion = read_fbx(save(SEVEN))
    assert motion.skeleton.names == ("Hips", "rig:Spine")
    assert (motion.frames, motion.fps) == (5, 24.0)
    pose = world_pose(motion)
    # metres already (UnitScaleFactor 100), Z up told as Y up
    np.testing.assert_allclose(pose.positions[:, 0], [[x, 1, 0] for x in range(5)], atol=1e-12)
    np.testing.assert_allclose(pose.positions[:, 1] - pose.positions[:, 0], [[0, 0.5, 0]] * 5, atol=1e-12)
    before = euler_to_quat(np.radians([90, 0, 0]), "XYZ")
    # FBX order 4 is ZXY: z turns first, y last
    turn = euler_to_quat(np.radians([20, 10, 30]), "YXZ")
    assert quat_distance(motion.rotations[:, 1], quat_multiply(before, turn)).max() < 1e-12
    np.testing.assert_array_equal(motion.skeleton.rest[1], motion.rotations[0, 1])


def test_six(save):
    path = save(SIX)
    assert list_takes(path) == ("Empty", "Bow")
    motion = read_fbx(path)
    assert motion.skeleton.names == ("Root", "Limb")
    assert (motion.frames, motion.fps) == (7, 20.0)
    np.testing.assert_allclose(motion.translations[0], [[0, 1, 0], [0, 0.5, 0]])
    level = euler_to_quat(np.radians([[0, 5, x] for x in (0, 4.5, 9, 9, 30, 45, 60)]), "ZYX")
    assert np.degrees(quat_distance(motion.rotations[:, 1], level)).max() < 1e-9
    with pytest.raises(ParameterError, match="'Empty', 'Bow'"):
        read_fbx(path, take="Walk")
    assert read_fbx(path, take="Empty").frames == 1


@pytest.mark.parametrize(
    "text",
    [
        "",
        "hello",
        "; FBX 7.4.0 project file",
        "; FBX 7.4.0 project file\n}",
        "; FBX 7.4.0 project file\nA: {",
        '; FBX 7.4.0 project file\nA: "never closed',
        "; FBX 7.4.0 project file\nA: *3 { a: 1,2 }",
        "; FBX 7.4.0 project file\nA: *3 { a: 1,x,2 }",
        "; FBX 7.4.0 project file\nA: *99999999999999999 { a: 1 }",
        "; FBX 7.4.0 project file\nA: *3",
        "; FBX 7.4.0 project file\n3",
        "; FBX 7.4.0 project file\n" + "A: {" * 300,
    ],
)
def test_text_that_is_no_fbx_is_refused(text, save):
    with pytest.raises(FormatError):
        read_fbx(save(text))


def test_a_cut_text_is_refused_or_read(save):
    faults = []
    for stop in range(0, len(SEVEN), 37):
        try:
            read_fbx(save(SEVEN[:stop]))
        except FormatError as error:
            faults.append(str(error))
    assert len(faults) > 20
    assert all("hand.fbx" in fault for fault in faults)


def test_numbers_of_every_kind():
    assert numbers("1,-2,3").dtype == np.int64
    np.testing.assert_array_equal(numbers(" 1.5,\n-2e3,3"), [1.5, -2000, 3])
    assert np.isnan(numbers("1,-1.#IND,2")[1])
    assert len(numbers("")) == 0
    assert numbers("9223372036854775807")[0] == 2**63 - 1
    assert numbers("99999999999999999999")[0] == 1e20
    tree = parse_ascii(b'; FBX 6.1.0 project file\nKey: 1,-2.5,L,T,"a;b",.5,nan\n;end\n')
    assert tree.nodes[0].properties[:6] == (1, -2.5, ord("L"), ord("T"), "a;b", 0.5)
