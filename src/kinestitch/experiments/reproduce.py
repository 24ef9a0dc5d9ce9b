"""The paper, reproduced: every experiment in one run, one report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from kinestitch.core.atomic import replacing
from kinestitch.errors import FormatError, OutputError
from kinestitch.experiments import (
    against_blender,
    axes,
    cost,
    effect,
    films,
    flips,
    overview,
    path,
    quality_table,
    stiffness,
)
from kinestitch.experiments.dataset import FOLDERS, DataSet, load
from kinestitch.experiments.html import as_html, as_json, as_markdown
from kinestitch.experiments.page import Section
from kinestitch.experiments.pdf import as_pdf

Progress = Callable[[str], None]
SAMPLES_NOTE = "Run on the generated samples: the same report, but the paper's clips were not there."


@dataclass(frozen=True, slots=True)
class Report:
    """All sections of one run, and what they were run on."""

    sections: tuple[Section, ...]
    data: str
    note: str


def data_sets(folder: Path | None) -> tuple[DataSet, ...]:
    """The data sets of a folder, the samples alone where there are none of them."""
    found = [load(folder, name) for name in FOLDERS]
    real = tuple(data for data in found if data.real)
    return real if real else (found[0],)


def reproduce(
    folder: Path | None, *, quick: bool = False, seed: int = 0, progress: Progress = lambda name: None
) -> Report:
    """Run every experiment; a seed makes it repeatable.

    folder : data sets as in ``FOLDERS``, or None for the generated samples
    quick : few cuts and small sizes, to see that everything works
    """
    sets = data_sets(folder)
    main = sets[0]
    cuts, seams, limit = (6, 6, 10) if quick else (40, 200, 10_000)
    sizes = (100, 300, 1_000) if quick else (100, 300, 1_000, 2_000, 10_000, 100_000, 1_000_000)
    steps: Sequence[tuple[str, Callable[[], Section]]] = (
        ("overview", overview.run),
        ("effect", lambda: effect.run(main, cuts=cuts, seed=seed)),
        ("against Blender", lambda: against_blender.run(main, cuts=2 if quick else 40, seed=seed)),
        ("across categories", lambda: path.cross_category(main)),
        ("root translation", lambda: path.root_path(main)),
        ("axes", lambda: axes.run(sets, seed=seed)),
        ("injected flip", lambda: flips.run_injected(main)),
        ("found flips", lambda: flips.run_detected(sets, limit=limit)),
        ("cost", lambda: cost.run(sizes=sizes)),
        ("stiffness", lambda: stiffness.run(main)),
        ("quality", lambda: quality_table.run(sets[:2], seams=seams, seed=seed)),
        ("videos", lambda: films.run(main, folder)),
    )
    sections = []
    for name, run in steps:
        progress(name)
        sections.append(run())
    progress("")
    data = ", ".join(f"{s.name} ({len(s.clips)} clips)" for s in sets)
    return Report(tuple(sections), data, "" if main.real else SAMPLES_NOTE)


def write_report(report: Report, folder: Path, *, docs: Path | None = None) -> tuple[Path, ...]:
    """Write ``report.html`` and ``report.pdf`` into a folder, ``results.md`` and ``results.json`` there or into `docs`.

    The last two hold nothing but aggregate numbers. Raises OutputError.
    """
    day = datetime.now(tz=UTC).date()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"Expected a folder that can be made, got: {error.strerror}. ({folder})") from error
    sections, data = report.sections, report.data
    made = {
        folder / "report.html": as_html(sections, data=data, day=day, note=report.note).encode(),
        folder / "report.pdf": as_pdf(sections, data=data, day=day, note=report.note),
        (docs or folder) / "results.md": as_markdown(sections, data=data, day=day).encode(),
        (docs or folder) / "results.json": as_json(sections, data=data, day=day).encode(),
    }
    for target, content in made.items():
        with replacing(target) as stream:
            stream.write(content)
    return tuple(made)


def check_folder(folder: Path) -> None:
    """Raise FormatError unless a folder of data is there and holds at least one of the data sets."""
    if not folder.is_dir():
        raise FormatError(f"Expected a folder of clips, got none. ({folder})")
    if not any((folder / name).is_dir() for name in FOLDERS.values()):
        raise FormatError(f"Expected one of the folders {', '.join(FOLDERS.values())} in it, got none. ({folder})")
