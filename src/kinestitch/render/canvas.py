"""A sheet of pixels for many pictures in a row: matplotlib's own rasteriser, without a figure built for each.

Shapes are antialiased to a fraction of a pixel, so that a slow movement does not crawl. Coordinates are pixels from
the lower left corner; colours are ``#rrggbb`` or (3,) in [0, 1].
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array

Colour = str | Array | tuple[float, ...]


@cache
def rgb(colour: str) -> tuple[float, float, float]:
    """Red, green and blue in [0, 1] of ``#rrggbb`` or a name that matplotlib knows."""
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def _rgba(colour: Colour, alpha: float) -> tuple[float, ...]:
    red, green, blue = rgb(colour) if isinstance(colour, str) else colour
    return float(red), float(green), float(blue), alpha


class Canvas:
    """A white sheet of `width` × `height` pixels."""

    def __init__(self, width: int, height: int) -> None:
        from matplotlib.backends.backend_agg import RendererAgg
        from matplotlib.transforms import IdentityTransform

        self.width, self.height = width, height
        self._renderer: Any = RendererAgg(width, height, 72)  # at 72 dpi a point is a pixel
        self._gc: Any = self._renderer.new_gc()
        self._gc.set_antialiased(True)
        self._gc.set_snap(False)  # level lines would jump from pixel to pixel
        self._as_is = IdentityTransform()
        self._kept: NDArray[np.uint8] | None = None
        self.pixels()[:] = 255

    def pixels(self) -> NDArray[np.uint8]:
        """The picture (height, width, 4) RGBA, first row on top; a view that the next stroke changes."""
        return np.asarray(self._renderer.buffer_rgba())

    def keep(self) -> None:
        """Remember the picture as it is now, for :meth:`restore`."""
        self._kept = self.pixels().copy()

    def restore(self) -> None:
        """Back to the picture that was kept."""
        if self._kept is not None:
            self.pixels()[:] = self._kept

    def clip(self, left: float, width: float) -> None:
        """From now on draw nothing outside these columns."""
        from matplotlib.transforms import Bbox

        self._gc.set_clip_rectangle(Bbox([[left, 0.0], [left + width, self.height]]))

    def shapes(
        self, outlines: Array, fill: Colour, *, alpha: float = 1.0, edge: Colour | None = None, width: float = 0.0
    ) -> None:
        """Fill polygons (N, K, 2), or one (K, 2), with one colour; where they overlap they are one shape."""
        self._stroke(edge, 1.0, width if edge is not None else 0.0)
        self._renderer.draw_path(self._gc, _path(outlines, closed=True), self._as_is, _rgba(fill, alpha))

    def lines(self, points: Array, colour: Colour, *, width: float = 1.0, alpha: float = 1.0) -> None:
        """Draw polylines (N, K, 2), or one (K, 2), of one width."""
        self._stroke(colour, alpha, width)
        self._renderer.draw_path(self._gc, _path(points, closed=False), self._as_is, None)

    def triangles(self, corners: Array, colours: Array) -> None:
        """Fill triangles (N, 3, 2) in their order, colours (N, 3, 3) blended from corner to corner."""
        opaque = np.concatenate([colours, np.ones((*colours.shape[:2], 1))], axis=-1)
        self._renderer.draw_gouraud_triangles(self._gc, corners, opaque, self._as_is)

    def text(
        self, x: float, y: float, words: str, *, size: float, colour: Colour, bold: bool = False, alpha: float = 1.0
    ) -> None:
        """Set words on one line, its left end at x and its baseline at y; `size` in pixels."""
        self._stroke(colour, alpha, 1.0)
        self._renderer.draw_text(self._gc, x, self.height - y, words, _font(size, bold), 0)

    def text_width(self, words: str, *, size: float, bold: bool = False) -> float:
        """Pixels that the words take."""
        return float(self._renderer.get_text_width_height_descent(words, _font(size, bold), False)[0])

    def fitting(self, words: str, room: float, *, size: float, bold: bool = False) -> str:
        """The words, cut short in the middle where they are wider than `room` pixels."""
        count = len(words)
        shown = words
        while count > 3 and self.text_width(shown, size=size, bold=bold) > room:
            count -= 1
            shown = f"{words[: count // 2]}…{words[len(words) - (count - count // 2 - 1) :]}"
        return shown

    def _stroke(self, colour: Colour | None, alpha: float, width: float) -> None:
        self._gc.set_linewidth(width)
        self._gc.set_foreground(_rgba("#000000" if colour is None else colour, alpha), isRGBA=True)
        self._gc.set_capstyle("butt")
        self._gc.set_joinstyle("round")


@cache
def _font(size: float, bold: bool) -> Any:
    from matplotlib.font_manager import FontProperties

    return FontProperties(family="DejaVu Sans", size=size, weight="bold" if bold else "normal")


@cache
def _codes(count: int, points: int, closed: bool) -> NDArray[np.uint8]:
    from matplotlib.path import Path

    codes = np.full((count, points + closed), Path.LINETO, dtype=np.uint8)
    codes[:, 0] = Path.MOVETO
    if closed:
        codes[:, -1] = Path.CLOSEPOLY
    return codes.ravel()


def _path(points: Array, *, closed: bool) -> Any:
    from matplotlib.path import Path

    points = points[None] if points.ndim == 2 else points
    count, length = points.shape[:2]
    if closed:
        points = np.concatenate([points, points[:, :1]], axis=1)
    return Path(points.reshape(-1, 2), _codes(count, length, closed))
