"""Replace a file only by a complete new one: write beside it, then rename."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from kinestitch.errors import KinestitchError, OutputError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """A binary file that takes the place of `path` when the block ends without an error, and leaves no trace otherwise.

    Raises OutputError if the folder is missing or cannot be written, or has no room for the file.
    """
    target = Path(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name[:40]}.", suffix=".part", dir=target.parent)
    except OSError as error:
        raise OutputError(
            f"Expected a folder that can be written, got: {error.strerror}. Choose another output path. ({target})"
        ) from error
    try:
        with os.fdopen(handle, "wb") as stream:
            yield stream
        umask = os.umask(0)
        os.umask(umask)
        Path(name).chmod(0o666 & ~umask)
        Path(name).replace(target)
    except IsADirectoryError as error:
        Path(name).unlink(missing_ok=True)
        raise OutputError(f"Expected a file to write, got a folder. Add a file name. ({target})") from error
    except OSError as error:
        Path(name).unlink(missing_ok=True)
        if isinstance(error, KinestitchError) or error.filename is not None:
            raise
        raise OutputError(
            f"Expected a file that can be written, got: {error.strerror}. Choose another output path. ({target})"
        ) from error
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
