"""What a person sees: tables on stdout, a progress bar on stderr when something takes its time."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

PATIENCE = 1.0
"""Seconds after which a progress bar appears."""

PIPED_WIDTH = 200
"""Columns of a table that goes to a file or another program, where nothing has to fit a screen."""


def console() -> Console:
    """Where results are printed; file names stay as they are, brackets and colons included."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else PIPED_WIDTH
    return Console(width=width, markup=False, emoji=False, highlight=False)


def fact_table() -> Table:
    """An empty block of facts, one a line: what it is in bold, then what it says."""
    from rich.table import Table

    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold")
    table.add_column(overflow="fold")
    return table


def counted(count: int, noun: str) -> str:
    """A number and its noun: ``1 frame``, ``2 frames``."""
    return f"{count} {noun}{'s' * (count != 1)}"


@contextmanager
def progress(steps: int) -> Iterator[Callable[[str], None]]:
    """A function that names the step which begins; after a second they show as a bar, if stderr is a terminal."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    bar = _Bar(steps)
    timer = threading.Timer(PATIENCE, bar.show)
    timer.daemon = True
    timer.start()
    try:
        yield bar.step
    finally:
        timer.cancel()
        bar.close()


class _Bar:
    """A rich progress bar that may be told of steps before it shows, and is gone when it closes."""

    def __init__(self, steps: int) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        screen = Console(stderr=True, markup=False, emoji=False, highlight=False)
        columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
        self._progress = Progress(*columns, console=screen, transient=True)
        self._task = self._progress.add_task("", total=steps)
        self._begun = -1
        self._closed = False
        self._lock = threading.Lock()

    def show(self) -> None:
        with self._lock:
            if not self._closed:
                self._progress.start()

    def step(self, name: str) -> None:
        self._begun += 1
        self._progress.update(self._task, description=name, completed=self._begun)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            self._progress.stop()
