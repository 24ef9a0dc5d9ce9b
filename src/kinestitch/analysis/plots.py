"""Curves to look at: one joint over time, and how strongly it accelerates, before and after its seams were solved; and
what every seam between two clips would cost.
"""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinestitch.core.atomic import replacing
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_continuous, quat_log, quat_mean, quat_multiply
from kinestitch.errors import SkeletonMismatchError, UnsupportedFormatError
from kinestitch.solve.contacts import Contacts, Mask, legs_of, runs
from kinestitch.solve.laplacian import second_difference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
_AXES = (("x", "#0072B2"), ("y", "#009E73"), ("z", "#D55E00"))
_BRIGHTEST = 95.0  # percent of a map's costs that the colours tell apart
_FEET = (("left", "#0072B2"), ("right", "#D55E00"))
_BEFORE, _AFTER, _SEAM = "#9A9A9A", "#111111", "#CC79A7"
_STANDS = "#009E73"


def joint_curve(motion: Motion, joint: int, base: Array | None = None) -> Array:
    """Rotation vectors (F, 3) rad of one joint, measured from its mean pose (or from `base`, (4,)), continuous in
    time.
    """
    rotations = motion.rotations[:, joint]
    base = quat_mean(rotations) if base is None else base
    moved = quat_continuous(quat_multiply(quat_conjugate(base), rotations))
    return quat_log(-moved if moved[:, 3].sum() < 0 else moved)


def plot_joint(
    motion: Motion,
    joint: int | str,
    path: str | os.PathLike[str],
    *,
    before: Motion | None = None,
    seams: Sequence[int] = (),
    title: str | None = None,
    contacts: Contacts | None = None,
) -> None:
    """Draw a joint's rotation vector over time and below it the norm of its temporal Laplacian; PNG, SVG or PDF by
    suffix.

    before : the hard cut of the same frames, drawn in grey behind; seams : frames to mark
    contacts : of the feet, drawn as bars at the bottom

    Raises UnsupportedFormatError, OutputError, InvalidMotionError (no such joint), SkeletonMismatchError (`before` is
    another motion).
    """
    index = motion.skeleton.index(joint) if isinstance(joint, str) else joint
    if before is not None and (before.frames, before.skeleton.names) != (motion.frames, motion.skeleton.names):
        raise SkeletonMismatchError(
            f"Expected the hard cut of the same {motion.frames} frames and joints, got {before.frames} frames."
        )
    figure, (upper, lower, *feet) = _joint_panels(contacts)
    base = quat_mean(motion.rotations[:, index])
    frames = np.arange(motion.frames)
    curves = [(motion, 1.8, 1.0)] if before is None else [(before, 0.9, 0.45), (motion, 1.8, 1.0)]
    for clip, width, alpha in curves:
        values = np.degrees(joint_curve(clip, index, base))
        for axis, (letter, colour) in enumerate(_AXES):
            label = letter if clip is motion else None
            upper.plot(frames, values[:, axis], color=colour, linewidth=width, alpha=alpha, label=label)
        size = np.linalg.norm(second_difference(values), axis=-1)
        name, colour = ("after", _AFTER) if clip is motion else ("before: hard cut", _BEFORE)
        lower.plot(frames, size, color=colour, linewidth=1.2, label=None if before is None else name)
    _mark((upper, lower, *feet), seams)
    if contacts is not None:
        _draw_contacts(feet[0], motion, contacts)
    upper.set_ylabel("rotation vector (°)")
    lower.set_ylabel("‖L r‖ (° per frame²)")
    (feet or [lower])[-1].set_xlabel(f"frame ({motion.fps:g} fps)")
    drawn = " (thin before, thick after)" if before is not None else ""
    upper.set_title(title if title is not None else motion.skeleton.names[index] + drawn, loc="left")
    upper.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, borderaxespad=0.0)
    if before is not None:
        lower.set_yscale("symlog", linthresh=1.0)
        lower.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, borderaxespad=0.0)
    _set_limits(upper, lower, motion.frames)
    save_figure(figure, path)


def plot_costs(
    costs: Array,
    path: str | os.PathLike[str],
    *,
    cuts: Sequence[tuple[int, int]] = (),
    names: tuple[str, str] = ("A", "B"),
    label: str = "cost",
    standing: tuple[Mask, Mask] | None = None,
) -> None:
    """Draw what every seam between two clips would cost as a map, with the chosen cuts numbered; suffix as for
    :func:`plot_joint`.

    costs : (F_a + 1, F_b + 1) by how many frames of the first clip are shown and where the second one begins
    cuts : such pairs; standing : (F_a, 2), (F_b, 2), when the left and the right foot stand, drawn as bars

    Raises UnsupportedFormatError, OutputError.
    """
    from matplotlib.colors import PowerNorm
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 5.6), layout="constrained")
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.set(w_pad=0.02, h_pad=0.02, wspace=0.0, hspace=0.0)  # type: ignore[call-arg]
    panels = figure.subplots(2, 2, sharex="col", sharey="row", height_ratios=(1, 18), width_ratios=(22, 1))
    (over, corner), (axes, beside) = panels
    shown = costs[1:, :-1]
    extent = (-0.5, shown.shape[1] - 0.5, -0.5, shown.shape[0] - 0.5)
    norm = PowerNorm(0.5, shown.min(), max(float(np.percentile(shown, _BRIGHTEST)), shown.min() + 1e-12))
    picture = axes.imshow(shown, origin="lower", extent=extent, aspect="auto", cmap="cividis_r", norm=norm)
    for number, (out, into) in enumerate(cuts, start=1):
        axes.plot(into, out - 1, "o", markersize=13, color=_SEAM, markeredgecolor="white", clip_on=False)
        axes.annotate(str(number), (into, out - 1), color="white", ha="center", va="center", fontsize=8, weight="bold")
    axes.set_xlabel(f"{names[1]} from this frame on")
    axes.set_ylabel(f"{names[0]} up to this frame")
    for side in (over, corner, beside):
        side.set_axis_off()
    if standing is not None:
        _feet(over, standing[1], beside, standing[0])
    figure.colorbar(picture, ax=panels, label=f"{label}; bright is cheap", extend="max")
    save_figure(figure, path)


def _feet(over: Axes, along: Mask, beside: Axes, upwards: Mask) -> None:
    """Bars above a map and to its right, in the frames in which each foot stands."""
    for row, (name, colour) in enumerate(_FEET):
        for start, stop in runs(along[:, row]):
            over.barh(-row, stop - start, 0.7, start - 0.5, color=colour)
        for start, stop in runs(upwards[:, row]):
            beside.bar(row, stop - start, 0.7, start - 0.5, color=colour)
        over.barh(0, 0, color=colour, label=f"{name} foot stands")
    over.set_ylim(-1.5, 0.5)
    beside.set_xlim(-0.5, 1.5)
    over.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, borderaxespad=0.0)


def _joint_panels(contacts: Contacts | None) -> tuple[Figure, Sequence[Axes]]:
    """Two panels, and a low one below them with a row for each of the contacts' joints."""
    from matplotlib.figure import Figure

    rows = 0 if contacts is None else len(contacts.joints)
    extra = [0.24 * rows + 0.1] if rows else []
    figure = Figure(figsize=(8.0, 5.0 + 0.8 * sum(extra)), layout="constrained")
    panels = figure.subplots(2 + len(extra), 1, sharex=True, height_ratios=(3, 2, *extra))
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
        panel.margins(x=0.01)
    return figure, panels


def _draw_contacts(axes: Axes, motion: Motion, contacts: Contacts) -> None:
    """A bar wherever a joint stands, the left foot's ankle and toe above the right one's."""
    sides = zip(("left", "right"), legs_of(motion.skeleton), strict=True)
    names = {joint: f"{side} {part}" for side, leg in sides for joint, part in ((leg.foot, "ankle"), (leg.toe, "toe"))}
    for row, held in enumerate(contacts.held.T):
        spans = [(start - 0.5, stop - start) for start, stop in runs(held)]
        axes.broken_barh(spans, (row - 0.32, 0.64), facecolors=_STANDS)
    count = len(contacts.joints)
    axes.set_yticks(range(count), [names[joint] for joint in contacts.joints], fontsize=8)
    axes.set_ylim(count - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)


def _set_limits(upper: Axes, lower: Axes, frames: int) -> None:
    """Axes of a degree and a frame at least, where a curve holds still or has a single frame."""
    low, high = upper.get_ylim()
    if high - low < 1.0:
        middle = (low + high) / 2
        upper.set_ylim(middle - 0.5, middle + 0.5)
    lower.set_ylim(0.0, max(lower.get_ylim()[1], 0.01))
    if frames == 1:
        upper.set_xlim(-0.5, 0.5)
        for panel in (upper, lower):
            for line in panel.lines:
                line.set_marker("o")


def _mark(panels: Sequence[Axes], seams: Sequence[int]) -> None:
    for number, frame in enumerate(seams):
        for panel in panels:
            panel.axvline(frame - 0.5, color=_SEAM, linewidth=1.2, linestyle="--", zorder=0)
        label = "seam" if number == 0 else ""
        panels[0].annotate(
            label, (frame - 0.5, 1.0), xycoords=("data", "axes fraction"), color=_SEAM, ha="left", va="top",
            xytext=(3, -1), textcoords="offset points",
        )  # fmt: skip


def save_figure(figure: Figure, path: str | os.PathLike[str], *, dpi: int = 150) -> None:
    """Write a figure as PNG, SVG or PDF by suffix; an existing file is replaced only by a complete new one.

    Raises UnsupportedFormatError for another suffix, OutputError where the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        found = repr(suffix) if suffix else "no suffix"
        raise UnsupportedFormatError(f"Expected a picture that ends in {', '.join(SUFFIXES)}, got {found}. ({path})")
    buffer = io.BytesIO()
    figure.savefig(buffer, format=suffix[1:], dpi=dpi)
    with replacing(path) as stream:
        stream.write(buffer.getvalue())
