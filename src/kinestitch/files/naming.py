"""Readers say what is wrong and where; this door adds the name of the file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from kinestitch.errors import FormatError, InvalidMotionError


@contextmanager
def naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn FormatError and InvalidMotionError of the block into a FormatError that ends with the path."""
    try:
        yield
    except (FormatError, InvalidMotionError) as error:
        raise FormatError(f"{error} ({path})") from error


def unique_names(names: list[str]) -> tuple[list[str], int]:
    """The names with ``_2``, ``_3``, … added to repeated ones, and how many had to be changed."""
    taken = set(names)
    seen: set[str] = set()
    result: list[str] = []
    changed = 0
    for name in names:
        new = name
        if name in seen:
            changed += 1
            number = 2
            while (new := f"{name}_{number}") in taken:
                number += 1
            taken.add(new)
        seen.add(name)
        result.append(new)
    return result, changed
