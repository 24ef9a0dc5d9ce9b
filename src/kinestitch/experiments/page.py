"""What a report is made of: sections with findings, figures and tables; plain values, no layout."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

Verdict = Literal["reproduced", "reproduced with limits", "not reproduced", "measured", "missing"]


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim, what was found, and the number it rests on."""

    claim: str
    verdict: Verdict
    evidence: str


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure as PNG or SVG bytes with its caption; `own` where it was made from the generated samples only."""

    caption: str
    data: bytes
    kind: Literal["png", "svg"] = "png"
    own: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under a head, with a caption."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Video:
    """An MP4 with its caption."""

    caption: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Section:
    """One experiment: what was asked, what came out.

    figures that later documents quote stand in `numbers`, by key; everything in them comes from the run
    """

    title: str
    text: str
    findings: tuple[Finding, ...] = ()
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()
    videos: tuple[Video, ...] = ()
    numbers: Mapping[str, object] = field(default_factory=dict)


def picture(drawing: Drawing, caption: str, *, own: bool = False, dpi: int = 110) -> Picture:
    """A Matplotlib figure as a picture of the report."""
    buffer = io.BytesIO()
    drawing.savefig(buffer, format="png", dpi=dpi)
    return Picture(caption, buffer.getvalue(), own=own)


def panels(rows: int = 1, columns: int = 1, *, size: tuple[float, float] = (8.0, 3.4)) -> tuple[Drawing, Sequence]:
    """A figure in the report's plain style and its axes, flat; pyplot is never imported."""
    from matplotlib.figure import Figure as Drawing

    drawing = Drawing(figsize=size, layout="constrained")
    axes = drawing.subplots(rows, columns, squeeze=False).ravel().tolist()
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
        axis.title.set_fontsize("medium")
    return drawing, axes


def rows_of(values: Sequence[Sequence[object]]) -> tuple[tuple[str, ...], ...]:
    """Table rows from anything: floats with three digits, the rest as text."""
    return tuple(tuple(f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in row) for row in values)
