"""What a clip goes through before it is pasted, in words: another frame rate, another size."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from kinestitch.cli.inputs import Opened

if TYPE_CHECKING:
    from kinestitch.core.skeleton import Skeleton

SAME_SIZE = 1e-3
"""Share by which the hip heights of two bodies of one size may differ."""


def changes(opened: Opened) -> list[str]:
    """A sentence for every clip of an edit that is resampled, or scaled to the body of the original."""
    from kinestitch.core.resample import same_rate
    from kinestitch.rig.hips import hip_height

    line = opened.timeline
    shown = list(dict.fromkeys(line.clip(segment.clip).source for segment in line.segments))
    first = line.original
    body = opened.clips[first].skeleton
    told = []
    for key in shown:
        clip, name = opened.clips[key], Path(opened.sources[key]).name
        if not same_rate(clip.fps, line.fps):
            told.append(f"{name}: {clip.fps:g} fps resampled to {line.fps:g}.")
        if _same_joints(clip.skeleton, body):
            scale = hip_height(body) / hip_height(clip.skeleton)
            if abs(scale - 1) >= SAME_SIZE:
                told.append(f"{name}: scaled by {scale:.3g} to the body of {Path(opened.sources[first]).name}.")
    return told


def _same_joints(one: Skeleton, other: Skeleton) -> bool:
    """Whether two rigs have the same joints; of others a retargeting tells."""
    from kinestitch.rig.hips import bare_name

    return sorted(map(bare_name, one.names)) == sorted(map(bare_name, other.names))
