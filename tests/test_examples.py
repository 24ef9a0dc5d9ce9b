"""Every program in examples/ and every Python block of the README and of docs/ runs, in an empty folder."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from kinestitch.errors import MissingExtraError

PROJECT = Path(__file__).parents[1]
EXAMPLES = sorted((PROJECT / "examples").glob("*.py"))
PAGES = [PROJECT / "README.md", *sorted((PROJECT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[int, str]]:
    """Line and text of every Python block of a page."""
    text = page.read_text(encoding="utf-8")
    return [(text.count("\n", 0, match.start(1)) + 1, match[1]) for match in BLOCK.finditer(text)]


WITH_BLOCKS = [page for page in PAGES if blocks(page)]


def test_there_is_something_to_run():
    assert EXAMPLES
    assert PAGES[0] in WITH_BLOCKS, "the README shows no Python"


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_example(path):
    runpy.run_path(str(path), run_name="__main__")


@pytest.mark.parametrize("page", WITH_BLOCKS, ids=lambda page: page.name)
def test_page(page):
    """The blocks of one page run one after the other and share their names."""
    names: dict[str, object] = {"__name__": "__main__"}
    for line, text in blocks(page):
        # Empty lines in front put the page's own line number into a traceback.
        try:
            exec(compile("\n" * (line - 1) + text, str(page), "exec"), names)
        except MissingExtraError as error:
            pytest.skip(str(error))
