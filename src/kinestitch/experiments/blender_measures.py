"""What is measured beside Blender: agreement with our crossfades, the trade-off curves, and punches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.analysis.smoothness import added_acceleration
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_distance, quat_multiply, quat_normalize
from kinestitch.edit.timeline import DEFAULT_SMOOTHING, Timeline
from kinestitch.experiments.blender_nla import WIDTHS, Blended, Mode
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.punches import Punch, strike_kept
from kinestitch.experiments.trade_off import MEASURES, REACH, WAYS, Curve, Way, measure
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.rivals import crossfade
from kinestitch.solve.rivals.blends import own_poses
from kinestitch.solve.stitch import stitch

BLENDER = "Blender NLA"
DEFAULT = "laplacian, default τ"


@dataclass(frozen=True, slots=True)
class Agreement:
    """Blender in one mode and at one width against ours, over cuts: degrees, all joints, frames and cuts.

    mean, largest : from our linear crossfade; eased : largest from our eased one
    way, share : where the largest is, the way from one source to the other, above 180 where following it through the
    window leads the long way round, and the right one's weight
    lerp : largest from quaternions interpolated component by component and then normalised
    """

    mode: Mode
    width: int
    mean: float
    largest: float
    way: float
    share: float
    eased: float
    lerp: float


@dataclass(frozen=True, slots=True)
class Struck:
    """A punch cut and one way over it: what is left of the strike's speed, what was added, changed and survived."""

    punch: Punch
    way: str
    strike: float
    added: float
    deviation: float
    survived: float


def widths_at(fps: float) -> tuple[int, ...]:
    """The widths of ``WIDTHS`` that lie within what is measured around a seam."""
    return tuple(width for width in WIDTHS if width <= REACH * fps)


def component_lerp(placed: Placed, width: int) -> tuple[int, Array]:
    """First frame and rotations (2 width, J, 4) of both sources' quaternions, of equal signs at the seam, interpolated
    linearly with the weights of ``crossfade`` and normalised.
    """
    (seam,) = placed.seams
    first, second = placed.timeline.segments
    frames = np.arange(-width, width)
    share = ((frames + width + 0.5) / (2 * width))[:, None, None]
    left, _ = own_poses(placed, 0, first.range.stop + frames)
    right, _ = own_poses(placed, 1, second.range.start + frames)
    relative = quat_multiply(quat_conjugate(left), right)
    flips = np.einsum("fji,fji->fj", relative[1:], relative[:-1]) < 0
    signs = np.cumprod(np.concatenate([np.ones((1, relative.shape[1])), np.where(flips, -1.0, 1.0)]), axis=0)
    w = (signs * relative[..., 3])[width - 1 : width + 1].sum(axis=0)
    signs = signs * np.where(w < 0, -1.0, 1.0)
    return seam.frame - width, quat_normalize((1 - share) * left + share * signs[..., None] * right)


def agreement(
    placed: Sequence[Placed], blended: Blended, widths: Sequence[int], modes: Sequence[Mode]
) -> list[Agreement]:
    """How far Blender is from our crossfades, by mode and width."""
    found = []
    for mode in modes:
        for width in widths:
            rows = np.array([_apart(one, blended.motions[one.timeline, width, mode], width) for one in placed])
            mean, (eased, lerp) = rows[:, 0].mean(), rows[:, 4:].max(axis=0)
            largest, way, share = rows[rows[:, 1].argmax(), 1:4]
            found.append(Agreement(mode, width, *map(float, (mean, largest, way, share, eased, lerp))))
    return found


def _apart(placed: Placed, theirs: Motion, width: int) -> tuple[float, ...]:
    (seam,) = placed.seams
    first, second = placed.timeline.segments
    reach = min(width, seam.frame, placed.frames - seam.frame)
    here = slice(seam.frame - reach, seam.frame + reach)
    linear, eased = (crossfade(placed, width, eased=e).rotations[here] for e in (False, True))
    # the carrier is told in the world inside and given back to another joint outside, so it is left out of the check
    kept = [j for j in range(placed.skeleton.joint_count) if j not in {placed.carrier, placed.writes}]
    _, lerp = component_lerp(placed, reach)
    own = theirs.rotations[here]
    away = np.degrees(quat_distance(own, linear))
    frame, joint = np.unravel_index(int(away.argmax()), away.shape)
    share, offset = (float(frame) + 0.5) / (2 * reach), int(frame) - reach
    near, weight = (first.range.stop, share) if share < 0.5 else (second.range.start, 1 - share)
    source, _ = own_poses(placed, int(share >= 0.5), np.array([near + offset]))
    way = float(np.degrees(quat_distance(source[0, joint], linear[frame, joint]))) / weight
    other = float(np.degrees(quat_distance(own, eased)).max())
    exact = float(np.degrees(quat_distance(own, lerp)[:, kept]).max())
    return float(away.mean()), float(away.max()), way, share, other, exact


def ways_with(blended: Blended, fps: float, widths: Sequence[int]) -> tuple[Way, ...]:
    """All methods of the trade-off, Blender at its widths, and ours at its default."""

    def look_up(placed: Placed, seconds: float) -> Motion:
        return blended.motions[placed.timeline, round(seconds * fps), "matched"]

    ours = Way(DEFAULT, "smoothing time τ", (DEFAULT_SMOOTHING,), WAYS[0].join)
    theirs = Way(BLENDER, "width on each side", tuple(width / fps for width in widths), look_up)
    return (*WAYS, theirs, ours)


def curves(cuts: Sequence[Timeline], clips: Mapping[str, Motion], ways: Sequence[Way]) -> dict[str, Curve]:
    """Every method over its whole range on the given cuts."""
    found: dict[str, list[Array]] = {way.name: [] for way in ways}
    for cut in cuts:
        for name, values in measure(cut, clips, ways).items():
            found[name].append(values)
    return {
        way.name: Curve(
            way.name,
            way.setting,
            way.settings,
            dict(zip(MEASURES, np.stack(found[way.name], axis=-1), strict=True)),
        )
        for way in ways
    }


def struck(found: Sequence[Punch], data: DataSet, blended: Blended, widths: Sequence[int]) -> list[Struck]:
    """Ours at its default and Blender at every width on the punches."""
    rows = []
    for punch in found:
        placed = place_timeline(punch.cut, data.clips)
        (seam,) = placed.seams
        hard = stitch(punch.cut, data.clips, method="cut")
        results = {DEFAULT: stitch(punch.cut, data.clips)}
        results |= {f"{BLENDER}, {w} frames": blended.motions[punch.cut, w, "matched"] for w in widths}
        reach = round(REACH * placed.timeline.fps)
        near = slice(max(0, seam.frame - reach), seam.frame + reach)
        for way, motion in results.items():
            added = added_acceleration(motion, placed, seam, reach)
            changed = float(np.degrees(quat_distance(motion.rotations[near], hard.rotations[near]).mean()))
            kept = strike_kept(motion, hard, punch)
            rows.append(Struck(punch, way, kept, added.peak, changed, added.survived))
    return rows
