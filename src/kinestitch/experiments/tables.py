"""What every experiment that writes a table asks of its caller, and how its page is put in its place."""

from __future__ import annotations

import argparse
from pathlib import Path

from kinestitch.core.atomic import replacing


def table_options(what: str | None, *, seams: int | None = 200) -> argparse.ArgumentParser:
    """A parser of FOLDER, ``--output`` and, unless `seams` is None, ``--seams`` and ``--seed``; what : the module's
    docstring, whose first line says what is measured.
    """
    parser = argparse.ArgumentParser(description=what.splitlines()[0] if what else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    if seams is not None:
        parser.add_argument("--seams", type=int, default=seams)
        parser.add_argument("--seed", type=int, default=0)
    return parser


def write_page(path: Path, text: str) -> None:
    """Write a page; one that is there already is replaced only by a complete new one."""
    with replacing(path) as stream:
        stream.write(text.encode())
