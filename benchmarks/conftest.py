"""Benchmarks show ratios against a named rival in the same run; absolute times on shared machines mean little."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import pytest


@dataclass(frozen=True)
class Ratio:
    """One comparison: `what` took `ratio` times as long as `rival`; the aim is told in words."""

    what: str
    rival: str
    ratio: float
    aim: str


_rows: list[Ratio] = []


def least_time(call: Callable[[], object], repeats: int) -> float:
    """Least of several runs in seconds, after one warm-up."""
    call()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
    return min(times)


@pytest.fixture(scope="session")
def quick(request: pytest.FixtureRequest) -> bool:
    """Whether this is a smoke run, which only shows that every benchmark still works."""
    return bool(request.config.getoption("benchmark_disable"))


@pytest.fixture
def compare(quick: bool) -> Callable[..., float]:
    """Time two calls alternately in one run and note the ratio for the table at the end."""

    def run(
        what: str, call: Callable[[], object], rival: str, other: Callable[[], object], aim: str, *, repeats: int = 40
    ) -> float:
        repeats = 1 if quick else repeats
        rounds = 1 if quick else 3
        mine = min(least_time(call, repeats) for _ in range(rounds))
        theirs = min(least_time(other, repeats) for _ in range(rounds))
        _rows.append(Ratio(what, rival, mine / theirs, aim))
        return mine / theirs

    return run


@pytest.fixture
def note() -> Callable[[str, str, float, str], None]:
    """Put a ratio into the table that was timed elsewhere in the same run: what, rival, ratio, aim."""

    def keep(what: str, rival: str, ratio: float, aim: str) -> None:
        _rows.append(Ratio(what, rival, ratio, aim))

    return keep


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--ratios", type=Path, default=None, help="write the table of ratios to this Markdown file")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    if not _rows:
        return
    lines = ["| what | rival, same run | time as a share of the rival's | aim |", "|---|---|---|---|"]
    lines += [f"| {row.what} | {row.rival} | {row.ratio:.2f} | {row.aim} |" for row in _rows]
    terminalreporter.section(
        "ratios" + (" (smoke run: one repeat, not meaningful)" if config.option.benchmark_disable else "")
    )
    terminalreporter.write_line("\n".join(lines))
    if config.option.ratios:
        text = "# Benchmarks\n\nMade by `make bench`; every row is a ratio of two timings of one run.\n\n"
        config.option.ratios.write_text(text + "\n".join(lines) + "\n", encoding="utf-8")
