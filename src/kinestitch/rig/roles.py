"""Which joint plays which part of a human body, told by names and by what hangs on what."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import FAMILIES, LIMBS, MAIN_ROLES, SIDES, Family
from kinestitch.rig.hips import bare_name, hips_joint

_PREFIX = re.compile(r"(?i)^(J_(Bip|Sec|Adj)_(C_)?|Bip0*1[_ ]|Bip_|Character\d+_|DEF-|ORG-)")
_WORD = re.compile(r"(?i)left|right")
_LETTER = re.compile(r"(?:^|[_.\- ])([lLrR])(?:[_.\- ]|$)")
_CAMEL = re.compile(r"^([lLrR])(?=[A-Z][a-z])")
_FIRST = re.compile(r"^([lr])(?=[a-z]{2})")
_NOISE = re.compile(r"[^a-z0-9]")


@dataclass(frozen=True)
class Roles:
    """Who is who on a rig.

    family : the name table that fits best; joints : role → joint index, in the order of the tables

    Roles are ``hips``, ``spine_1`` … up to the chest, ``neck_1`` …, ``head``, and with ``left_`` or ``right_`` before
    them ``shoulder``, ``upper_arm``, ``lower_arm``, ``hand``, ``upper_leg``, ``lower_leg``, ``foot``, ``toe`` and
    ``thumb_1`` … ``pinky_4`` (number 0 lies in the palm).
    """

    family: str
    joints: Mapping[str, int]

    @property
    def missing(self) -> tuple[str, ...]:
        """The main roles that nobody plays."""
        return tuple(role for role in MAIN_ROLES if role not in self.joints)

    def chain(self, part: str) -> tuple[int, ...]:
        """The joints of the spine or of the neck, from below."""
        return tuple(joint for role, joint in self.joints.items() if role.startswith(f"{part}_"))


@lru_cache(maxsize=64)
def roles_of(skeleton: Skeleton) -> Roles:
    """The roles of a rig's joints in the family that explains most of them.

    >>> from kinestitch.samples import sample
    >>> roles_of(sample("walk").skeleton).missing
    ()
    """
    best = None
    for family in FAMILIES:
        parts = _parts(skeleton, family)
        roles = Roles(family.name, MappingProxyType(_roles_from(skeleton, family, parts)))
        score = (-len(roles.missing), len(parts), len(roles.joints))
        if best is None or score > best[0]:
            best = (score, roles)
    assert best is not None
    return best[1]


def _readings(name: str) -> list[tuple[str, str]]:
    """(side, part) pairs that a joint's name may mean, the likeliest first; side is empty on the middle line."""
    bare = _PREFIX.sub("", bare_name(name))
    readings = []
    for pattern in (_WORD, _LETTER, _CAMEL, _FIRST):
        match = pattern.search(bare)
        if match:
            side = SIDES[0] if match.group(0).strip("_.- ").lower().startswith("l") else SIDES[1]
            readings.append((side, _plain(bare[: match.start()] + " " + bare[match.end() :])))
    return [*readings, ("", _plain(bare))]


def _plain(text: str) -> str:
    return _NOISE.sub("", text.lower())


def _parts(skeleton: Skeleton, family: Family) -> dict[str, int]:
    """Part of the body → the first joint whose name says so."""
    parts: dict[str, int] = {}
    for joint, name in enumerate(skeleton.names):
        for side, plain in _readings(name):
            part = (family.sided if side else family.middle).get(plain)
            if part:
                role = f"{side}_{part}" if side else part
                parts.setdefault(name if part in ("unused", "spine", "neck") else role, joint)
                break
    return parts


def _roles_from(skeleton: Skeleton, family: Family, parts: dict[str, int]) -> dict[str, int]:
    hips = hips_joint(skeleton)
    roles = {"hips": hips, **_trunk(skeleton, hips, parts.get("head"), family)}
    for side in SIDES:
        for limb in LIMBS.values():
            roles.update(_limb(skeleton, hips, {part: parts.get(f"{side}_{part}") for part in limb}, side))
        roles.update(_extremities(skeleton, roles, parts, side))
    return roles


def _trunk(skeleton: Skeleton, hips: int, head: int | None, family: Family) -> dict[str, int]:
    """Spine and neck: what stands between the hips and the head."""
    if head is None or hips not in skeleton.chain(head)[:-1]:
        return {}
    path = skeleton.chain(head)
    between = path[path.index(hips) + 1 : -1]
    necks = [joint for joint in between if family.middle.get(_readings(skeleton.names[joint])[-1][1]) == "neck"]
    first = necks[0] if necks else head
    spine = [joint for joint in between if joint < first]
    neck = [joint for joint in between if joint >= first]
    return {
        **{f"spine_{n}": joint for n, joint in enumerate(spine, start=1)},
        **{f"neck_{n}": joint for n, joint in enumerate(neck, start=1)},
        "head": head,
    }


def _limb(skeleton: Skeleton, hips: int, parts: dict[str, int | None], side: str) -> dict[str, int]:
    """A limb's joints from the body outwards, as far as each hangs on the one before it."""
    found, above = {}, hips
    for part, joint in parts.items():
        if joint is None or above not in skeleton.chain(joint)[:-1]:
            break
        found[f"{side}_{part}"] = above = joint
    return found


def _extremities(skeleton: Skeleton, roles: dict[str, int], parts: dict[str, int], side: str) -> dict[str, int]:
    """The shoulder above the arm, the toe below the foot, the fingers below the hand."""
    found = {}
    arm, shoulder = roles.get(f"{side}_upper_arm"), parts.get(f"{side}_shoulder")
    if arm is not None and shoulder is not None and shoulder in skeleton.chain(arm)[:-1]:
        found[f"{side}_shoulder"] = shoulder
    for role, joint in parts.items():
        if not role.startswith(f"{side}_") or role in roles or role == f"{side}_shoulder":
            continue
        above = roles.get(f"{side}_foot" if role == f"{side}_toe" else f"{side}_hand")
        last = role.rpartition("_")[2]
        if above is not None and above in skeleton.chain(joint)[:-1] and (last.isdigit() or role == f"{side}_toe"):
            found[role] = joint
    return found
