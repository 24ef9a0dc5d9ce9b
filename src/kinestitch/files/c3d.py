"""C3D in: markers and analog channels of motion laboratories."""

from __future__ import annotations

import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from kinestitch.core.recording import Recording
from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError, KinestitchWarning
from kinestitch.files.c3d_bytes import MIPS, check_whole, little_endian, processor
from kinestitch.files.extras import optional
from kinestitch.files.naming import naming, unique_names
from kinestitch.files.rates import snap_rate

LIBRARIES = ("ezc3d",)
"""What an isolated reader imports before its memory is limited."""

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
"""Metres of the units that POINT:UNITS may name."""


def read_c3d(path: str | os.PathLike[str]) -> Recording:
    """Read the markers and the analog channels of a C3D file (the extra ``c3d``).

    Markers come in metres by ``POINT:UNITS`` (millimetres where it is missing). The world is turned so that the axis
    that ``POINT:Y_SCREEN`` names points up (+Y) and that of ``POINT:X_SCREEN`` to +X; without them the file's Z is up
    and its X stays. A marker with a residual below zero, or a number that is none, was not seen and is NaN. Analog
    channels are in the file's own units, scaled by its gains, each with its name and unit. Rates are ``POINT:RATE``
    and ``ANALOG:RATE``. Channels and markers without a label get a number; repeated names get ``_2``, ``_3``, … with
    one counted KinestitchWarning.

    Files of Intel, DEC and SGI machines are read. Events, force plates and residuals are left out.

    Raises FormatError for damaged files, MissingExtraError without ezc3d, FileNotFoundError. ezc3d is native code: read
    files that you do not trust with ``files.read_recording(path, isolated=True)``.
    """
    path = Path(path)
    data = path.read_bytes()
    ezc3d = optional("ezc3d", "c3d")
    with naming(path), np.errstate(all="ignore"):
        content = _load(ezc3d, path, data)
        parameters = {name: _group(group) for name, group in content["parameters"].items() if isinstance(group, dict)}
        point, analog = parameters.get("POINT", {}), parameters.get("ANALOG", {})
        markers = _markers(content, point)
        values = np.array(content["data"]["analogs"], dtype=np.float64)
        values = values.reshape(values.shape[-2:]).T if values.size else np.zeros((0, values.shape[-2]))
        rate = _rate(point, float(content["header"]["points"]["frame_rate"]))
        return Recording(
            markers,
            _labels(point, markers.shape[1], "marker"),
            rate,
            values,
            _labels(analog, values.shape[1], "channel"),
            _padded(_texts(analog.get("UNITS")), values.shape[1]),
            _rate(analog, rate) if values.shape[1] else rate,
            path.stem,
        )


def _load(ezc3d: Any, path: Path, data: bytes) -> Any:
    """What ezc3d makes of the file, or of its copy in another byte order."""
    with tempfile.TemporaryDirectory() as folder:
        if processor(data) == MIPS:
            data = little_endian(data)
            path = Path(folder) / "turned.c3d"
            path.write_bytes(data)
        check_whole(data)
        try:
            with _silenced():
                return ezc3d.c3d(str(path))
        except (RuntimeError, ValueError, IndexError, KeyError, OSError, TypeError, OverflowError) as error:
            reason = " ".join(str(error).split())[:160] or type(error).__name__
            raise FormatError(f"Expected a sound C3D file, got: {reason}.") from error
        except MemoryError as error:
            raise FormatError("Expected a sound C3D file, got one that asks for more memory than there is.") from error


@contextmanager
def _silenced() -> Iterator[None]:
    """What the library prints goes nowhere."""
    sys.stdout.flush()
    sys.stderr.flush()
    try:
        kept = [(handle, os.dup(handle)) for handle in (1, 2)]
    except OSError:
        kept = []
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for handle, _ in kept:
            os.dup2(nowhere, handle)
        yield
    finally:
        for handle, copy in kept:
            os.dup2(copy, handle)
            os.close(copy)
        os.close(nowhere)


def _group(group: dict[str, Any]) -> dict[str, Any]:
    return {name: entry.get("value") for name, entry in group.items() if isinstance(entry, dict)}


def _texts(value: Any) -> list[str]:
    """Texts of a parameter; what is no UTF-8 is Latin-1."""
    if not isinstance(value, (list, tuple)):
        return []
    raw = [str(entry).encode("utf-8", "surrogateescape") for entry in value]
    texts = []
    for entry in raw:
        try:
            texts.append(entry.decode("utf-8"))
        except UnicodeDecodeError:
            texts.append(entry.decode("latin-1"))
    return [text.strip(" \0") for text in texts]


def _padded(texts: list[str], count: int) -> tuple[str, ...]:
    return tuple((texts + [""] * count)[:count])


def _labels(group: dict[str, Any], count: int, what: str) -> tuple[str, ...]:
    texts = _texts(group.get("LABELS"))
    number = 2
    while len(texts) < count and (more := _texts(group.get(f"LABELS{number}"))):
        texts, number = texts + more, number + 1
    named = [text or f"{what} {index}" for index, text in enumerate(_padded(texts, count))]
    names, repeated = unique_names(named)
    if repeated:
        warnings.warn(
            KinestitchWarning(f"{repeated} {what} name(s) used twice; a number was added to them."), stacklevel=4
        )
    return tuple(names)


def _rate(group: dict[str, Any], default: float) -> float:
    values = np.asarray(group.get("RATE", ())).reshape(-1)
    rate = float(values[0]) if values.size and values.dtype.kind in "fiu" else 0.0
    rate = rate if np.isfinite(rate) and rate > 0 else default
    if not (np.isfinite(rate) and 0 < rate < 1e7):
        raise FormatError(f"Expected a rate > 0, got {rate}.")
    return snap_rate(rate)


def _markers(content: Any, point: dict[str, Any]) -> Array:
    """Markers (F, M, 3) m, Y up, NaN where one was not seen."""
    points = np.array(content["data"]["points"], dtype=np.float64)
    markers = np.moveaxis(points[:3], 0, -1).swapaxes(0, 1)
    unit = next(iter(_texts(point.get("UNITS"))), "").lower() or "mm"
    if unit not in UNITS:
        raise FormatError(f"Expected POINT:UNITS out of {', '.join(UNITS)}, got {unit[:24]!r}.")
    seen = np.asarray(np.isfinite(markers).all(axis=-1))
    residuals = np.array(content["data"]["meta_points"]["residuals"], dtype=np.float64)
    if residuals.size == seen.size:
        seen &= ~(residuals.reshape(seen.shape[::-1]).T < 0)
    placed = markers @ _axes(point).T * UNITS[unit]
    return np.where(seen[..., None], placed, np.nan)


def _axes(point: dict[str, Any]) -> Array:
    """Rotation (3, 3) from the laboratory's axes to Y up."""
    across, up = (_axis(point.get(name)) for name in ("X_SCREEN", "Y_SCREEN"))
    if up is None:
        across, up = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    elif across is None or across @ up:
        across = np.eye(3)[1 if up[0] else 0]
    return np.array([across, up, np.cross(across, up)])


def _axis(value: Any) -> Array | None:
    """Unit vector of ``+X``, ``-z`` and so on."""
    text = next(iter(_texts(value)), "").upper()
    letter = text.lstrip("+-")
    if letter not in ("X", "Y", "Z"):
        return None
    return np.eye(3)["XYZ".index(letter)] * (-1.0 if text.startswith("-") else 1.0)
