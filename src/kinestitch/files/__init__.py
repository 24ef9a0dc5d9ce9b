"""How a motion enters and leaves: one reader and one writer per suffix, all units and axes changed at this door."""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinestitch.errors import FormatError, ParameterError, UnsupportedFormatError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.core.recording import Recording


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
    Format("AMASS", (".npz",), "amass"),
    Format("USD", (".usd", ".usda", ".usdc"), "usd", extra="usd"),
    Format("USD package", (".usdz",), "usd", writes=False, extra="usd"),
    Format("C3D", (".c3d",), "c3d", writes=False, extra="c3d", records=True),
)


def format_of(path: str | os.PathLike[str]) -> Format:
    """The format that a path's suffix names; raises UnsupportedFormatError with the list of known ones."""
    suffix = Path(path).suffix.lower()
    for entry in FORMATS:
        if suffix in entry.suffixes:
            return entry
    known = ", ".join(s for entry in FORMATS for s in entry.suffixes)
    found = repr(suffix) if suffix else "no suffix"
    raise UnsupportedFormatError(
        f"Expected a file that ends in {known}, got {found}. Convert it to one of these. ({path})"
    )


def _function(entry: Format, verb: str) -> Callable[..., Any]:
    return getattr(importlib.import_module(f"kinestitch.files.{entry.module}"), f"{verb}_{entry.module}")


def read(path: str | os.PathLike[str], *, isolated: bool = False, **options: Any) -> Motion:
    """Read a clip from a file: metres, Y up, quaternions xyzw, whatever the file uses.

    path : ends in one of the suffixes of ``FORMATS``
    isolated : read in a child process, for files that are not trusted (see :mod:`kinestitch.files.isolated`)
    options : the format's own, by name (``unit=`` for BVH, ``take=`` for FBX, glTF and USD)

    Raises UnsupportedFormatError (also for recordings, which :func:`read_recording` reads), FormatError (damaged or not
    of this format), FileNotFoundError, MissingExtraError where the format needs a library that is not installed.
    """
    path = Path(path)
    entry = format_of(path)
    if entry.records:
        raise UnsupportedFormatError(
            f"Expected a clip of a skeleton, got {entry.name}, which holds markers. Use read_recording. ({path})"
        )
    return _read(path, entry, "read", isolated, options)


def read_recording(path: str | os.PathLike[str], *, isolated: bool = False, **options: Any) -> Recording:
    """Read markers and analog channels from a file of a motion laboratory (.c3d): metres, Y up.

    Raises what :func:`read` raises; UnsupportedFormatError for clips.
    """
    path = Path(path)
    entry = format_of(path)
    if not entry.records:
        raise UnsupportedFormatError(
            f"Expected a recording of markers, got {entry.name}, which holds a clip. Use read. ({path})"
        )
    return _read(path, entry, "read_recording", isolated, options)


def _read(path: Path, entry: Format, verb: str, isolated: bool, options: dict[str, Any]) -> Any:
    if path.is_dir():
        raise FormatError(f"Expected a file, got a folder. Name a file in it. ({path})")
    if isolated:
        from kinestitch.files.isolated import Isolated

        with Isolated() as reader:
            return getattr(reader, verb)(path, **options)
    try:
        return _function(entry, "read")(path, **options)
    except TypeError as error:
        _explain_option(error, entry, "read", options)
        raise


def write(
    motion: Motion, path: str | os.PathLike[str], *, like: str | os.PathLike[str] | None = None, **options: Any
) -> None:
    """Write a motion to a file; an existing one is replaced only by a complete new one.

    like : a file of the same format from which everything but the animation is kept. Mesh, skin, materials, textures,
        cameras, extras and extensions are its untouched bytes; only the take that was read is replaced, others stay.
        Without it the file holds the skeleton and its motion alone.
    options : the format's own, by name

    With `like` the motion has to be one of the file's own figure. Joints are matched by name, whatever prefix stands
    before a colon, and may be told in other axes; joints that only the file has keep their rest. Reading the new file
    gives the motion back, on the file's skeleton. `like` and `path` may be one file.

    Raises UnsupportedFormatError, OutputError; with `like` also ParameterError where it is of another format or its
    format cannot keep anything, SkeletonMismatchError that names joints which the file lacks, FormatError and
    FileNotFoundError of reading it.
    """
    entry = format_of(path)
    if not entry.writes:
        raise UnsupportedFormatError(
            f"Expected a format that can be written, got {entry.name}, which is read only. ({path})"
        )
    if like is not None:
        _check_like(entry, like, path)
        options["like"] = Path(like)
    try:
        _function(entry, "write")(motion, Path(path), **options)
    except TypeError as error:
        _explain_option(error, entry, "write", options)
        raise


def can_keep(path: str | os.PathLike[str]) -> bool:
    """Whether :func:`write` knows ``like=`` for files with this suffix; raises UnsupportedFormatError."""
    entry = format_of(path)
    return entry.writes and "like" in inspect.signature(_function(entry, "write")).parameters


def has_character(path: str | os.PathLike[str]) -> bool:
    """Whether a file holds a mesh beside its motion; a quick look that reads no animation.

    Formats that know no meshes, and damaged files, have none. Raises UnsupportedFormatError, FileNotFoundError.
    """
    entry = format_of(path)
    module = importlib.import_module(f"kinestitch.files.{entry.module}")
    look = getattr(module, f"has_character_{entry.module}", None)
    try:
        return look is not None and bool(look(Path(path)))
    except FormatError:
        return False


def _check_like(entry: Format, like: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    if format_of(like) is not entry:
        raise ParameterError(
            f"Expected like= to be of the output's format, {entry.name}, got {Path(like).name!r}. "
            f"Choose an output of that file's format. ({path})"
        )
    if not can_keep(path):
        raise ParameterError(f"Expected a format whose files can be kept, got {entry.name}. Leave like= out. ({path})")


def _explain_option(error: TypeError, entry: Format, verb: str, options: dict[str, Any]) -> None:
    for option in options:
        if f"unexpected keyword argument '{option}'" in str(error):
            told = inspect.signature(_function(entry, verb)).parameters.values()
            known = ", ".join(parameter.name for parameter in told if parameter.kind is parameter.KEYWORD_ONLY)
            raise ParameterError(
                f"Expected an option of {entry.name} ({known or 'it has none'}), got {option!r}."
            ) from error
