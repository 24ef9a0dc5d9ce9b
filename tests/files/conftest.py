"""The table of real files that is told at the end of a run; one line per file."""

from __future__ import annotations

import pytest

ROWS = pytest.StashKey[list[str]]()


@pytest.fixture
def tell_file(request: pytest.FixtureRequest) -> list[str]:
    """Lines for the table, in the order in which files were read."""
    return request.config.stash.setdefault(ROWS, [])


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    rows = config.stash.get(ROWS, [])
    if rows:
        refused = sum(": refused: " in row for row in rows)
        terminalreporter.section(f"real files: {len(rows) - refused} read, {refused} refused")
        terminalreporter.write_line("\n".join(rows))
