"""A clip made to fit another clip's rig: told anew where it is the same rig, retargeted where names are certain."""

from __future__ import annotations

import warnings
from functools import lru_cache

from kinestitch.core.motion import Motion
from kinestitch.errors import KinestitchWarning, SkeletonMismatchError
from kinestitch.rig.match import match_motion


def fit_motion(motion: Motion, onto: Motion, name: str) -> Motion:
    """The motion on the rig of `onto`: as :func:`match_motion` where that knows how, else retargeted.

    name : what the clip is called in messages

    A KinestitchWarning says that a clip is retargeted, once for each pair of motions. Raises SkeletonMismatchError
    with the list of joints that are not found where names do not tell all main joints of both rigs.
    """
    try:
        return match_motion(motion, onto.skeleton)
    except SkeletonMismatchError as error:
        return _retargeted(motion, onto, name, str(error))


@lru_cache(maxsize=16)
def _retargeted(motion: Motion, onto: Motion, name: str, why: str) -> Motion:
    from kinestitch.rig.mapping import find_mapping, unmatched
    from kinestitch.rig.retarget import retargeted, unmapped_note

    mapping = find_mapping(motion.skeleton, onto.skeleton)
    if not mapping.certain:
        raise SkeletonMismatchError(
            f"{why.partition('. ')[0]}; clip {name!r} cannot be retargeted by names, which do not tell "
            f"{unmatched(mapping)}. Rename or retarget it with a mapping first."
        )
    result = retargeted(motion, onto.skeleton, mapping, example=onto)
    ours, theirs = mapping.source_family, mapping.target_family
    families = f"onto another {ours} rig" if ours == theirs else f"from {ours} to {theirs} joints"
    note = f" {unmapped_note(result)}" if result.unmapped else ""
    warnings.warn(f"Clip {name!r} is retargeted {families}.{note}", KinestitchWarning, stacklevel=2)
    return result.motion
