"""The child of :mod:`kinestitch.files.isolated`: reads the files that it is told to, and says nothing but answers."""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import warnings
from pathlib import Path
from typing import IO, Any

from kinestitch import files
from kinestitch.errors import KinestitchError, KinestitchWarning
from kinestitch.files.messages import message_of, receive, send

_LONGEST_REQUEST = 1 << 20


def serve() -> None:
    """Answer requests until the pipe closes; whatever libraries print goes nowhere."""
    with os.fdopen(os.dup(0), "rb") as requests, os.fdopen(os.dup(1), "wb") as answers:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for handle in (0, 1, 2):
            os.dup2(nowhere, handle)
        _limit("RLIMIT_CORE", 0)
        while True:
            try:
                request, _ = receive(requests, _LONGEST_REQUEST)
            except EOFError:
                return
            _answer(answers, request)


def _answer(answers: IO[bytes], request: dict[str, Any]) -> None:
    path = Path(request["path"])
    blobs: list[bytes] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            _load(path)
            _limit("RLIMIT_AS", _address_space() + request["memory"])
            read = getattr(files, request["verb"])
            head, blobs = message_of(read(path, **request["options"]))
        except BaseException as error:
            head = {"error": _kind(error), "message": str(error)}
    _limit("RLIMIT_AS", -1)
    head["warnings"] = [str(w.message) for w in caught if issubclass(w.category, KinestitchWarning)]
    send(answers, json.dumps(head).encode(), blobs)


def _kind(error: BaseException) -> str:
    """Name of the error, or of the first of its bases that everybody knows."""
    known = (entry for entry in type(error).__mro__ if entry.__module__ in ("builtins", KinestitchError.__module__))
    return next(known).__name__


def _load(path: Path) -> None:
    """Import what reading will need, before memory is limited."""
    with contextlib.suppress(KinestitchError):
        module = importlib.import_module(f"kinestitch.files.{files.format_of(path).module}")
        for library in getattr(module, "LIBRARIES", ()):
            with contextlib.suppress(ImportError):
                importlib.import_module(library)


def _address_space() -> int:
    """Bytes of address space that this process has by now; 0 where the system does not say."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def _limit(kind: str, size: int) -> None:
    """Set a soft limit where the system has one; -1 takes it away."""
    try:
        import resource
    except ImportError:
        return
    number = getattr(resource, kind)
    hard = resource.getrlimit(number)[1]
    soft = hard if size < 0 or (hard != resource.RLIM_INFINITY and size > hard) else size
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(number, (soft, hard))


if __name__ == "__main__":
    serve()
