"""Which joint of one rig follows which joint of another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import SkeletonMismatchError
from kinestitch.rig.families import MAIN_ROLES
from kinestitch.rig.hips import bare_name
from kinestitch.rig.roles import Roles, roles_of


@dataclass(frozen=True, slots=True)
class Pair:
    """A joint of the target and what it follows.

    target, source : joint names; towards, share : the target turns like a joint that stands at `share` in [0, 1] of
    the way from `source` to `towards`, which is how a spine of three joints moves one of four
    """

    target: str
    source: str
    towards: str = ""
    share: float = 0.0


@dataclass(frozen=True, slots=True)
class Mapping:
    """The pairs of joints of two rigs, and the families whose names told them.

    missing : main roles that one of the rigs has nobody for, as ``left_hand of the source``; none of them: `certain`
    """

    pairs: tuple[Pair, ...]
    source_family: str = ""
    target_family: str = ""
    missing: tuple[str, ...] = ()

    @property
    def certain(self) -> bool:
        """Whether hips, spine, head, both arms and both legs were found on both rigs."""
        return not self.missing

    def unmapped(self, skeleton: Skeleton) -> tuple[str, ...]:
        """The joints of the target that follow nothing and keep their rest."""
        mapped = {pair.target for pair in self.pairs}
        return tuple(name for name in skeleton.names if name not in mapped)


def find_mapping(source: Skeleton, target: Skeleton) -> Mapping:
    """Pair the joints of two rigs by the roles that their names tell; see :mod:`kinestitch.rig.families`.

    Spines and necks of different joint counts are matched by their place along the way from hips to chest and from
    chest to head. Joints without a role follow one of the same name, if there is one.

    Nothing is raised where joints are missing: look at ``certain`` and ``missing``.
    """
    ours, theirs = roles_of(source), roles_of(target)
    missing = [f"{role} of the source" for role in ours.missing]
    missing += [f"{role} of the target" for role in theirs.missing]
    pairs = [
        Pair(target.names[joint], source.names[ours.joints[role]])
        for role, joint in theirs.joints.items()
        if role in ours.joints and not role.startswith(("spine_", "neck_"))
    ]
    pairs += _spread(source, target, _trunk(ours), theirs.chain("spine"), len(theirs.chain("spine")))
    pairs += _spread(source, target, _upper(ours), theirs.chain("neck"), len(theirs.chain("neck")) + 1)
    pairs += _same_names(source, target, ours, theirs)
    place = {name: joint for joint, name in enumerate(target.names)}
    pairs.sort(key=lambda pair: place[pair.target])
    return Mapping(tuple(pairs), ours.family, theirs.family, tuple(missing))


def _trunk(roles: Roles) -> tuple[int, ...]:
    """From the hips to the chest, in equal steps."""
    return (roles.joints["hips"], *roles.chain("spine"))


def _upper(roles: Roles) -> tuple[int, ...]:
    """From the chest to the head, in equal steps; nothing without a head."""
    head = (roles.joints["head"],) if "head" in roles.joints else ()
    return (_trunk(roles)[-1], *roles.chain("neck"), *head) if head else ()


def _spread(
    source: Skeleton, target: Skeleton, knots: tuple[int, ...], joints: tuple[int, ...], steps: int
) -> list[Pair]:
    """Each joint at its share of the way along the source's knots, of which the first belongs to the part before."""
    if len(knots) < 2:
        return []
    pairs = []
    for number, joint in enumerate(joints, start=1):
        place = number * (len(knots) - 1) / steps
        below = int(np.floor(place + 1e-9))
        share = round(place - below, 6)
        name = source.names[knots[below]]
        if share > 0:
            pairs.append(Pair(target.names[joint], name, source.names[knots[below + 1]], share))
        else:
            pairs.append(Pair(target.names[joint], name))
    return pairs


def _same_names(source: Skeleton, target: Skeleton, ours: Roles, theirs: Roles) -> list[Pair]:
    """Joints that play no role and share a name: eyes, props, tails.

    Within one family a name means the same whether or not it is known what its joint plays.
    """
    taken = set() if ours.family == theirs.family else set(ours.joints.values())
    above = set(source.chain(ours.joints["hips"])), set(target.chain(theirs.joints["hips"]))
    named = {
        bare_name(name).lower(): name
        for joint, name in enumerate(source.names)
        if joint not in taken and joint not in above[0]
    }
    played = set(theirs.joints.values())
    return [
        Pair(name, named[bare_name(name).lower()])
        for joint, name in enumerate(target.names)
        if joint not in played and joint not in above[1] and bare_name(name).lower() in named
    ]


def unmatched(mapping: Mapping) -> str:
    """The main roles that a mapping misses, as words: ``head, left_hand of the source``."""
    words = []
    for side in ("source", "target"):
        roles = [text.removesuffix(f" of the {side}") for text in mapping.missing if text.endswith(side)]
        if len(roles) >= len(MAIN_ROLES) - 1:
            words.append(f"any limb of the {side}")
        elif roles:
            words.append(f"{', '.join(roles)} of the {side}")
    return "; ".join(words)


def check_mapping(mapping: Mapping, source: Skeleton, target: Skeleton) -> None:
    """Raise SkeletonMismatchError unless every pair names joints that both rigs have, and each target once."""
    seen: set[str] = set()
    for pair in mapping.pairs:
        for name, skeleton, side in (
            (pair.target, target, "target"),
            (pair.source, source, "source"),
            (pair.towards or pair.source, source, "source"),
        ):
            if name not in skeleton.names:
                raise SkeletonMismatchError(
                    f"Expected a joint of the {side} rig in the mapping, got {name!r}. "
                    f"Its joints are {', '.join(skeleton.names[:4])}…. Edit the mapping."
                )
        if pair.target in seen:
            raise SkeletonMismatchError(f"Expected each joint once in the mapping, got {pair.target!r} twice. Edit it.")
        seen.add(pair.target)
