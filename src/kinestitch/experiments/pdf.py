"""The report as a PDF: the same words, pictures and tables on pages; videos are named only."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING

from kinestitch.experiments.html import DOI, TITLE
from kinestitch.experiments.page import Section

if TYPE_CHECKING:
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.figure import Figure

_PAGE = (8.27, 11.69)  # inches, A4
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.08, 0.92, 0.95, 0.05
_LINE = 0.0135
_COLUMNS = 108


class _Pages:
    """A pen on growing pages: text and pictures go below each other, a new page starts where they do not fit."""

    def __init__(self, book: PdfPages) -> None:
        self.book = book
        self.page: Figure | None = None
        self.y = 0.0

    def room(self, height: float) -> Figure:
        """The page, with at least `height` (share of the page) left below the pen."""
        from matplotlib.figure import Figure

        if self.page is None or self.y - height < _BOTTOM:
            self.finish()
            self.page, self.y = Figure(figsize=_PAGE), _TOP
        return self.page

    def finish(self) -> None:
        """Put the page into the book."""
        if self.page is not None:
            self.book.savefig(self.page)
        self.page = None

    def text(self, words: str, *, size: float = 8.5, bold: bool = False, mono: bool = False) -> None:
        """One paragraph."""
        columns = int(_COLUMNS * 8.5 / size * (0.88 if mono else 1.0))
        for line in textwrap.wrap(words, columns) or [""]:
            step = _LINE * size / 8.5
            self.room(step).text(
                _LEFT, self.y, line.replace("$", r"\$"), size=size, va="top",
                weight="bold" if bold else "normal", family="monospace" if mono else "sans-serif",
            )  # fmt: skip
            self.y -= step

    def picture(self, data: bytes) -> None:
        """One PNG over the width of the page."""
        from matplotlib.image import imread

        pixels = imread(io.BytesIO(data))
        height = (_RIGHT - _LEFT) * _PAGE[0] * pixels.shape[0] / pixels.shape[1] / _PAGE[1]
        scale = min(1.0, (_TOP - _BOTTOM) / height)
        page = self.room(height * scale + 0.01)
        axes = page.add_axes((_LEFT, self.y - height * scale, (_RIGHT - _LEFT) * scale, height * scale))
        axes.imshow(pixels, interpolation="lanczos")
        axes.set_axis_off()
        self.y -= height * scale + 0.01


def as_pdf(sections: Sequence[Section], *, data: str, day: date, note: str = "") -> bytes:
    """The whole report as the bytes of a PDF."""
    from matplotlib.backends.backend_pdf import PdfPages

    buffer = io.BytesIO()
    with PdfPages(buffer, metadata={"Title": TITLE}) as book:
        pages = _Pages(book)
        pages.text(TITLE, size=16, bold=True)
        pages.text(
            f"{day.isoformat()}, run on {data}. Method: doi:{DOI}. Every number was computed in this run. {note}"
        )
        for number, section in enumerate(sections):
            _write(pages, number, section)
        pages.finish()
    return buffer.getvalue()


def _write(pages: _Pages, number: int, section: Section) -> None:
    pages.text("")
    pages.text(f"{number} · {section.title}", size=12, bold=True)
    pages.text(section.text)
    for finding in section.findings:
        pages.text(f"{finding.claim} — {finding.verdict}", bold=True)
        pages.text(finding.evidence)
    for picture in section.pictures:
        if picture.kind == "png":
            pages.picture(picture.data)
        pages.text(picture.caption, size=7.5)
    for table in section.tables:
        pages.text("")
        pages.text(table.caption, size=7.5, bold=True)
        for row in (table.head, *table.rows):
            pages.text("  |  ".join(row), size=6.5, mono=True)
    for video in section.videos:
        pages.text(f"(video in the HTML report) {video.caption}", size=7.5)
