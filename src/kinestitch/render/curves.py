"""Families of curves on shared axes: one method beside its rivals, each over its whole range."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinestitch.analysis.plots import save_figure
from kinestitch.core.rotation import Array
from kinestitch.errors import ParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#111111", "#0072B2", "#56B4E9", "#D55E00", "#E69F00", "#009E73", "#CC79A7", "#9A9A9A")
_MARKERS = "os^DvPX*"


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """One curve: its label and points x, y (P,); high : (P,) drawn thin and dashed above it, where there is one."""

    label: str
    x: Array
    y: Array
    high: Array | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Panel:
    """Curves on one pair of axes, with what each axis means; either may be logarithmic."""

    lines: tuple[Line, ...]
    x_label: str
    y_label: str
    x_log: bool = True
    y_log: bool = False


def draw_panels(panels: Sequence[Panel], *, title: str = "") -> Figure:
    """Panels side by side. Curves of one label share colour and marker; the first label is drawn strongest.

    Raises ParameterError for no panels, or more labels than can be told apart.
    """
    from matplotlib.figure import Figure

    labels = list(dict.fromkeys(line.label for panel in panels for line in panel.lines))
    if not panels or not 0 < len(labels) <= len(_COLOURS):
        raise ParameterError(f"Expected panels with 1 to {len(_COLOURS)} different curves, got {len(labels)}.")
    figure = Figure(figsize=(5.2 * len(panels), 4.6), layout="constrained")
    for panel, axes in zip(panels, np.atleast_1d(figure.subplots(1, len(panels))), strict=True):
        for line in panel.lines:
            _draw(axes, line, labels.index(line.label))
        axes.spines[["top", "right"]].set_visible(False)
        axes.set(xlabel=panel.x_label, ylabel=panel.y_label)
        axes.set_xscale("log" if panel.x_log else "linear")
        axes.set_yscale("log" if panel.y_log else "linear")
        axes.grid(True, which="major", color="#E4E4E4", linewidth=0.6)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=min(4, len(labels)), frameon=False)
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def _draw(axes: Axes, line: Line, number: int) -> None:
    colour, first = _COLOURS[number], number == 0
    axes.plot(
        line.x, line.y, color=colour, marker=_MARKERS[number], markersize=4.5, label=line.label,
        linewidth=2.4 if first else 1.3, zorder=3 if first else 2,
    )  # fmt: skip
    if line.high is not None:
        axes.plot(line.x, line.high, color=colour, linewidth=1.4 if first else 0.7, linestyle=":", zorder=1.5)


def plot_panels(panels: Sequence[Panel], path: str | os.PathLike[str], *, title: str = "") -> None:
    """Write :func:`draw_panels` as PNG, SVG or PDF by suffix. Raises UnsupportedFormatError, OutputError too."""
    save_figure(draw_panels(panels, title=title), path)
