"""Name tables: how families of rigs call the joints of a human body.

A table tells the part of the body by the name without its prefix, side and separators, in lower case: ``LeftForeArm``
and ``forearm.L`` both read ``forearm``. Parts on the middle line and parts with a side are told apart, since SMPL calls
the joint of the leg ``hip`` and others call the pelvis so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

FINGERS = ("thumb", "index", "middle", "ring", "pinky")


@dataclass(frozen=True)
class Family:
    """One way of naming joints.

    middle, sided : bare name → part of the body (``spine``, ``upper_arm``, ``index_1`` …); ``unused`` is known, and not
    carried over: the single finger of CMU's files says nothing about the others
    """

    name: str
    middle: Mapping[str, str]
    sided: Mapping[str, str]


def _numbered(form: str, counts: tuple[int, ...] = (1, 2, 3, 4), **other: str) -> dict[str, str]:
    """``form`` with {finger} and {n} filled in; `other` renames fingers."""
    return {form.format(finger=other.get(finger, finger), n=n): f"{finger}_{n}" for finger in FINGERS for n in counts}


def _phalanges(names: tuple[str, ...], **other: str) -> dict[str, str]:
    return {
        other.get(finger, finger) + name: f"{finger}_{n}" for finger in FINGERS for n, name in enumerate(names, start=1)
    }


def _by_number(finger: str, phalanges: tuple[str, ...], first: int) -> dict[str, str]:
    """Rigs that count fingers from the thumb: ``finger2proximal``, with the number of the first phalanx."""
    number = int(finger[-1]) - 1
    return {finger + name: f"{FINGERS[number]}_{n}" for n, name in enumerate(phalanges, start=first)}


_MIDDLE = {"hips": "hips", "pelvis": "hips", "neck": "neck", "neck1": "neck", "neck2": "neck", "head": "head"}
_SPINES = {f"spine{n}": "spine" for n in ("", *range(10))}
_CHESTS = {f"chest{n}": "spine" for n in ("", *range(1, 5))}
_LIMBS = {
    "shoulder": "shoulder",
    "upperarm": "upper_arm",
    "lowerarm": "lower_arm",
    "hand": "hand",
    "upperleg": "upper_leg",
    "lowerleg": "lower_leg",
    "foot": "foot",
}
_ARMS = {"shoulder": "shoulder", "arm": "upper_arm", "forearm": "lower_arm", "hand": "hand"}
_JOINTED = {
    "collar": "shoulder",
    "shoulder": "upper_arm",
    "elbow": "lower_arm",
    "wrist": "hand",
    "hip": "upper_leg",
    "knee": "lower_leg",
    "ankle": "foot",
}
_LEGS = {"upleg": "upper_leg", "leg": "lower_leg", "foot": "foot", "toebase": "toe", "forefoot": "toe", "toe": "toe"}

FAMILIES: tuple[Family, ...] = (
    Family(
        "Mixamo",
        {**_MIDDLE, **_SPINES},
        {
            **_ARMS,
            **_LEGS,
            **_numbered("hand{finger}{n}"),
            **{f"inhand{finger}": f"{finger}_0" for finger in FINGERS[1:]},
        },
    ),
    Family(
        "CMU",
        {
            **_MIDDLE,
            **dict.fromkeys(("lowerback", "upperback", "thorax", "spine", "spine1"), "spine"),
            **dict.fromkeys(("lowerneck", "upperneck"), "neck"),
            "root": "hips",
        },
        {
            **_ARMS,
            **_LEGS,
            "clavicle": "shoulder",
            "humerus": "upper_arm",
            "radius": "lower_arm",
            "wrist": "hand",
            "femur": "upper_leg",
            "tibia": "lower_leg",
            "toes": "toe",
            **dict.fromkeys(("hipjoint", "thumb", "fingers", "fingerbase", "handindex1"), "unused"),
        },
    ),
    Family("Bandai-Namco", {**_MIDDLE, "spine": "spine", "chest": "spine"}, {**_LIMBS, "toes": "toe"}),
    Family(
        "Biovision",
        {**_MIDDLE, **_CHESTS, "ab": "spine", "lowerback": "spine", "lowerneck": "neck"},
        {**_JOINTED, "toe": "toe", "toes": "toe"},
    ),
    Family(
        "SMPL",
        {**_MIDDLE, **_SPINES},
        {**_JOINTED, "foot": "toe", **_numbered("{finger}{n}", (1, 2, 3))},
    ),
    Family(
        "Unreal",
        {**_MIDDLE, **{f"spine0{n}": "spine" for n in range(1, 8)}, "neck01": "neck", "neck02": "neck"},
        {
            "clavicle": "shoulder",
            "upperarm": "upper_arm",
            "lowerarm": "lower_arm",
            "hand": "hand",
            "thigh": "upper_leg",
            "calf": "lower_leg",
            "foot": "foot",
            "ball": "toe",
            **_numbered("{finger}0{n}", (1, 2, 3)),
            **{f"{finger}metacarpal": f"{finger}_0" for finger in FINGERS[1:]},
        },
    ),
    Family(
        "Unity",
        {**_MIDDLE, "spine": "spine", "chest": "spine", "upperchest": "spine"},
        {
            **_LIMBS,
            "toes": "toe",
            **_phalanges(("proximal", "intermediate", "distal"), pinky="little"),
        },
    ),
    Family(
        "VRM",
        {**_MIDDLE, "spine": "spine", "chest": "spine", "upperchest": "spine"},
        {
            **_LIMBS,
            "toebase": "toe",
            **_numbered("{finger}{n}", (1, 2, 3), pinky="little"),
        },
    ),
    Family(
        "Rokoko",
        {**_MIDDLE, **_SPINES},
        {
            **_ARMS,
            "thigh": "upper_leg",
            "shin": "lower_leg",
            "foot": "foot",
            "toe": "toe",
            **_by_number("finger1", ("metacarpal", "proximal", "distal"), 1),
            **{
                name: part
                for finger in ("finger2", "finger3", "finger4", "finger5")
                for name, part in _by_number(finger, ("metacarpal", "proximal", "medial", "distal"), 0).items()
            },
        },
    ),
    Family(
        "Xsens",
        {**_MIDDLE, **dict.fromkeys(("l5", "l3", "t12", "t8"), "spine")},
        {**_LIMBS, "forearm": "lower_arm", "toe": "toe"},
    ),
    Family(
        "Biped",
        {**_MIDDLE, **_SPINES},
        {
            "clavicle": "shoulder",
            "upperarm": "upper_arm",
            "forearm": "lower_arm",
            "hand": "hand",
            "thigh": "upper_leg",
            "calf": "lower_leg",
            "foot": "foot",
            "toe0": "toe",
            **{f"finger{n}": f"{finger}_1" for n, finger in enumerate(FINGERS)},
            **{f"finger{n}{k}": f"{finger}_{k + 1}" for n, finger in enumerate(FINGERS) for k in (1, 2)},
        },
    ),
    Family(
        "generic",
        {
            **_MIDDLE,
            **_SPINES,
            **_CHESTS,
            **dict.fromkeys(("abdomen", "belly", "waist", "torso", "upperchest", "upperbody", "body"), "spine"),
        },
        {
            **dict.fromkeys(("clavicle", "collar", "collarbone", "shoulder"), "shoulder"),
            **dict.fromkeys(("upperarm", "uparm", "arm", "bicep"), "upper_arm"),
            **dict.fromkeys(("lowerarm", "lowarm", "forearm", "elbow"), "lower_arm"),
            **dict.fromkeys(("hand", "wrist", "palm"), "hand"),
            **dict.fromkeys(("upperleg", "upleg", "thigh", "hip"), "upper_leg"),
            **dict.fromkeys(("lowerleg", "lowleg", "shin", "calf", "knee", "leg"), "lower_leg"),
            **dict.fromkeys(("foot", "ankle"), "foot"),
            **dict.fromkeys(("toes", "toe", "toebase", "ball"), "toe"),
            **_numbered("{finger}{n}", (1, 2, 3)),
            **_numbered("{finger}0{n}", (1, 2, 3)),
        },
    ),
)
"""In the order in which they win where two fit a rig equally well. ReadyPlayerMe's avatars have Mixamo's names."""

LIMBS = {
    "arm": ("upper_arm", "lower_arm", "hand"),
    "leg": ("upper_leg", "lower_leg", "foot"),
}
SIDES = ("left", "right")
MAIN_ROLES: tuple[str, ...] = (
    "hips",
    "spine_1",
    "head",
    *(f"{side}_{part}" for limb in LIMBS.values() for part in limb for side in SIDES),
)
"""The roles that a rig must have for its motion to be understood without a person's help."""
