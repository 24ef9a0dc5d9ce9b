"""How a motion enters and leaves: one reader and one writer per suffix, all units and axes changed at this door."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinestitch.errors import FormatError, ParameterError, UnsupportedFormatError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion


@dataclass(frozen=True, slots=True)
class Format:
    """One file format: its name, its suffixes, the module of this room that knows it, and what it can do.

    extra : of the package, that installs the library which the format needs; empty where none is needed
    records : holds a Recording (markers, analog channels) instead of a Motion
    """

    name: str
    suffixes: tuple[str, ...]
    module: str
    reads: bool = True
    writes: bool = True
    extra: str = ""
    records: bool = False


FORMATS: tuple[Format, ...] = (
    Format("BVH", (".bvh",), "bvh"),
    Format("FBX", (".fbx",), "fbx"),
    Format("glTF", (".glb", ".gltf"), "gltf"),
    Format("AMC", (".amc",), "amc", writes=False),
)


def format_of(path: str | os.PathLike[str]) -> Format:
    """The format that a path's suffix names; raises UnsupportedFormatError with the list of known ones."""
    suffix = Path(path).suffix.lower()
    for entry in FORMATS:
        if suffix in entry.suffixes:
            return entry
    known = ", ".join(s for entry in FORMATS for s in entry.suffixes)
    raise UnsupportedFormatError(f"Expected a file that ends in {known}, got {suffix or 'no suffix'!r}. ({path})")


def _function(entry: Format, verb: str) -> Callable[..., Any]:
    return getattr(importlib.import_module(f"kinestitch.files.{entry.module}"), f"{verb}_{entry.module}")


def read(path: str | os.PathLike[str], **options: Any) -> Motion:
    """Read a clip from a file: metres, Y up, quaternions xyzw, whatever the file uses.

    path : ends in one of the suffixes of ``FORMATS``
    options : the format's own, by name (``unit=`` for BVH, ``take=`` for FBX and glTF)

    Raises UnsupportedFormatError, FormatError (damaged or not of this format), FileNotFoundError.
    """
    path = Path(path)
    entry = format_of(path)
    if path.is_dir():
        raise FormatError(f"Expected a file, got a folder. ({path})")
    try:
        return _function(entry, "read")(path, **options)
    except TypeError as error:
        _explain_option(error, entry, options)
        raise


def write(motion: Motion, path: str | os.PathLike[str], **options: Any) -> None:
    """Write a motion to a file; an existing one is replaced only by a complete new one.

    Raises UnsupportedFormatError, OutputError.
    """
    entry = format_of(path)
    if not entry.writes:
        raise UnsupportedFormatError(
            f"Expected a format that can be written, got {entry.name}, which is read only. ({path})"
        )
    try:
        _function(entry, "write")(motion, Path(path), **options)
    except TypeError as error:
        _explain_option(error, entry, options)
        raise


def _explain_option(error: TypeError, entry: Format, options: dict[str, Any]) -> None:
    for option in options:
        if f"unexpected keyword argument '{option}'" in str(error):
            raise ParameterError(f"Expected an option of {entry.name}, got {option!r}.") from error
