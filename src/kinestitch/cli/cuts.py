"""The verb ``cuts``: where one clip goes over into another most cheaply."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.console import console, counted, progress
from kinestitch.cli.inputs import is_document, read_clip
from kinestitch.cli.options import CLIP, FILE, NOT_NEGATIVE
from kinestitch.cli.outputs import check_output, refuse_suffix

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.search.price import Cut, Places, PriceMap
    from kinestitch.solve.contacts import Mask

Named = tuple[str, int | None, int | None]

FEWEST = 4
"""Frames of a clip in which cuts are looked for: the half of them that stays at least still has a velocity."""


@click.command(no_args_is_help=True, short_help="List the cheapest cuts from one clip into another.")
@click.argument("first", metavar="A", type=CLIP)
@click.argument("second", metavar="B", type=CLIP)
@click.option("--top", type=click.IntRange(1, 1000), default=5, show_default=True, metavar="N", help="How many.")
@click.option("--smooth", type=NOT_NEGATIVE, metavar="SECONDS", help="Smoothing time of the seam.  [default: 0.1]")
@click.option("--lambda", "stiffness", type=NOT_NEGATIVE, metavar="X", help="The same as the method's own λ.")
@click.option("--even", is_flag=True, help="Search by plain price: all joints alike, root's speed and feet left out.")
@click.option(
    "--contacts/--no-contacts", default=True, show_default=True, help="Prefer cuts inside stances of the same foot."
)
@click.option("--plot", type=FILE, metavar="OUT", help="Draw the map of all cuts: .png, .svg or .pdf.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def cuts(
    ctx: click.Context,
    *,
    first: Named,
    second: Named,
    top: int,
    smooth: float | None,
    stiffness: float | None,
    even: bool,
    contacts: bool,
    plot: str | None,
    as_json: bool,
) -> None:
    """List the cheapest cuts from clip A into clip B, each well apart from the others.

    A and B are clips and maybe a range of their frames to look in, PATH@START:STOP. The price is how many rad² the
    solved seam will cost, known before it is solved; the cost is the same with weighted joints, the root's speed and
    the feet that stand, and what the list is ordered by.

    \b
    Examples:
      kinestitch cuts walk.bvh kick.bvh
      kinestitch cuts walk.bvh@40:90 kick.bvh@:60 --top 3 --plot map.png
      kinestitch cuts walk.fbx walk.fbx@:30 --smooth 0.2 --json
    """
    _check(ctx, first, second, smooth, stiffness, plot)
    with progress(4) as step:
        a, b = _read(first[0], step), _read(second[0], step)
        step("pricing all cuts")
        from kinestitch.search.price import best_cuts, price_map

        weights = "even" if even else None
        prices = price_map(a, b, stiffness=stiffness, smoothing=smooth, weights=weights, contacts=contacts)
        outs, intos = _window(first, a, prices.a, last=True), _window(second, b, prices.b, last=False)
        found = best_cuts(prices, top, outs=outs, intos=intos, exact=True)
        if plot is not None:
            step("drawing")
            _draw(prices, found, (first[0], second[0]), plot)
    if as_json:
        click.echo(_json(prices, found, b.fps), nl=False)
    else:
        _show(prices, found, b, (first[0], second[0]))


def _check(
    ctx: click.Context, first: Named, second: Named, smooth: float | None, stiffness: float | None, plot: str | None
) -> None:
    from kinestitch.errors import UnsupportedFormatError

    if smooth is not None and stiffness is not None:
        raise click.UsageError("Expected --smooth or --lambda, got both. Leave one out.", ctx)
    for path in (first[0], second[0]):
        if is_document(path):
            raise UnsupportedFormatError(f"Expected a clip, got an edit. Use kinestitch stitch first. ({path})")
    if plot is not None:
        refuse_suffix(plot, (".png", ".svg", ".pdf"))
        check_output(plot, [first[0], second[0]])


def _read(path: str, step: Any) -> Motion:
    """A clip to cut; raises RangeError for one too short to have a movement that could go on."""
    from kinestitch.errors import RangeError

    step(f"reading {Path(path).name}")
    motion = read_clip(path)
    if motion.frames < FEWEST:
        raise RangeError(
            f"Expected a clip of at least {FEWEST} frames to look for cuts in, got "
            f"{counted(motion.frames, 'frame')}. Choose a longer clip. ({path})"
        )
    return motion


def _window(named: Named, own: Motion, told: Motion, *, last: bool) -> Places | None:
    """The places that a range of a clip's own frames names: those after its frames for A, before them for B."""
    from kinestitch.core.resample import resampled_bound
    from kinestitch.edit.timeline import FrameRange
    from kinestitch.errors import RangeError

    path, start, stop = named
    if start is None and stop is None:
        return None
    span = FrameRange(start or 0, own.frames if stop is None else stop)
    if span.stop > own.frames:
        raise RangeError(f"Expected frames within 0:{own.frames}, got {span}. ({path})")
    bounds = [min(resampled_bound(n, own.frames, own.fps, told.fps), told.frames) for n in (span.start, span.stop)]
    first = min(bounds[0], told.frames - 1)
    stop = max(bounds[1], first + 1)
    return (first + 1, stop) if last else (first, stop - 1)


def _own_frame(prices: PriceMap, into: int, fps: float) -> int:
    """A frame of B in B's own count."""
    return round(into * fps / prices.b.fps)


def _json(prices: PriceMap, found: Sequence[Cut], fps: float) -> str:
    from dataclasses import asdict

    from kinestitch.cli.seam_table import as_json

    listed = [{**asdict(cut), "into": _own_frame(prices, cut.into, fps), "difference": cut.difference} for cut in found]
    told = {"lambda": prices.stiffness, "fps": prices.a.fps, "weighted": prices.weighted}
    return as_json({**told, "contacts": prices.standing is not None, "cuts": listed})


def _show(prices: PriceMap, found: Sequence[Cut], b: Motion, paths: tuple[str, str]) -> None:
    from rich.table import Table

    out = console()
    names = [Path(path).stem for path in paths]
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    feet = () if prices.standing is None else ("feet",)
    for title in ("#", f"{names[0]} up to", f"{names[1]} from", "cost", "price rad²", "off the map's", *feet):
        table.add_column(title, justify="left" if title == "feet" else "right", overflow="fold")
    for number, cut in enumerate(found, start=1):
        into = _own_frame(prices, cut.into, b.fps)
        told = [f"{cut.exact_cost:.4g}", f"{cut.price:.4g}", f"{100 * cut.difference:+.1f} %"]
        if prices.standing is not None:
            before, after = prices.standing[0][cut.out - 1], prices.standing[1][cut.into]
            told.append(f"{_feet(before)} → {_feet(after)}")
        table.add_row(str(number), str(cut.out - 1), str(into), *told)
    out.print(table)
    out.print("Price: exact, as it will be solved; off the map's: by how much that differs from the map's own price.")
    if found:
        best = found[0]
        rest = f" --delete {best.out}:{prices.a.frames}" if best.out < prices.a.frames else ""
        into = _own_frame(prices, best.into, b.fps)
        out.print(f"kinestitch stitch {paths[0]}{rest} --append {paths[1]}@{into}: -o OUT")


def _feet(held: Mask) -> str:
    """Which of the feet (left, right) stand, in words."""
    return "both" if held.all() else "none" if not held.any() else "left" if held[0] else "right"


def _draw(prices: PriceMap, found: Sequence[Cut], paths: tuple[str, str], output: str) -> None:
    from kinestitch.analysis.plots import plot_costs

    first, second = (Path(path).stem for path in paths)
    label = "cost" if prices.weighted else "price E* (rad²)"
    places = [(cut.out, cut.into) for cut in found]
    plot_costs(prices.costs, output, cuts=places, names=(first, second), label=label, standing=prices.standing)
