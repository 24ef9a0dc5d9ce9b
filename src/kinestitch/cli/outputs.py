"""Before anything is read: an output has to have a known suffix, a folder to stand in, and no input under its name."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from kinestitch.errors import OutputError, ParameterError, UnsupportedFormatError

DOCUMENT = ".otio"


def check_suffix(path: str, *, documents: bool = False) -> None:
    """Raise UnsupportedFormatError unless a motion (or an edit document) can be written under this name."""
    from kinestitch.files import FORMATS

    known = [suffix for entry in FORMATS if entry.writes for suffix in entry.suffixes]
    known += [DOCUMENT] if documents else []
    refuse_suffix(path, known)


def refuse_suffix(path: str, known: Iterable[str]) -> None:
    """Raise UnsupportedFormatError unless the path ends in one of these."""
    suffix = Path(path).suffix
    if suffix.lower() not in known:
        found = repr(suffix) if suffix else "no suffix"
        raise UnsupportedFormatError(
            f"Expected an output that ends in {', '.join(known)}, got {found}. Choose one of these. ({path})"
        )


def check_output(path: str, inputs: Iterable[str], *, also: Iterable[str] = ()) -> None:
    """Raise OutputError where the path is no place for a file, ParameterError where it is an input.

    also : other outputs, which must be other files
    """
    target = Path(path)
    if target.is_dir():
        raise OutputError(f"Expected a file to write, got a folder. Add a file name. ({path})")
    if target.exists() and not target.is_file():
        raise OutputError(f"Expected a file to write, got a device or a pipe. Choose another path. ({path})")
    if not target.parent.is_dir():
        raise OutputError(f"Expected an existing folder to write into, got {str(target.parent)!r}. Make it. ({path})")
    if not os.access(target.parent, os.W_OK):
        raise OutputError(f"Expected a folder that can be written, got one that is read only. ({path})")
    for source in inputs:
        if same_file(path, source):
            raise ParameterError(f"Expected an output beside the inputs, got an input. Choose another path. ({path})")
    for other in also:
        if same_file(path, other):
            raise ParameterError(f"Expected two outputs of different names, got one twice. ({path})")


def same_file(one: str, other: str) -> bool:
    """Whether two paths mean one file, through links of either kind."""
    if os.path.realpath(one) == os.path.realpath(other):
        return True
    try:
        return Path(one).samefile(other)
    except OSError:
        return False
