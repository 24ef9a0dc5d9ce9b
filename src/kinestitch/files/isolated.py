"""Reading in a child process: what crashes, hangs or swallows memory there is a FormatError here."""

from __future__ import annotations

import builtins
import json
import os
import subprocess
import sys
import threading
import warnings
from pathlib import Path
from types import TracebackType
from typing import Any

import kinestitch.errors
from kinestitch.core.motion import Motion
from kinestitch.core.recording import Recording
from kinestitch.errors import FormatError, KinestitchError, KinestitchWarning, ParameterError
from kinestitch.files.messages import receive, send, value_of
from kinestitch.files.naming import naming

TIMEOUT = 60.0
"""Seconds that one file may take."""

MEMORY = 1 << 30
"""Bytes that one file may take beyond what the libraries themselves do."""

_SINGLE = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "PXR_WORK_THREAD_LIMIT"), "1")


def read_isolated(
    path: str | os.PathLike[str], *, timeout: float = TIMEOUT, memory: int = MEMORY, **options: Any
) -> Motion:
    """Read a clip as :func:`kinestitch.files.read` does, in a child process of its own.

    timeout : s; a child that takes longer is ended
    memory : bytes that the child may take for the file (where the system can limit it: not on Windows)
    options : the format's own, as ``files.read`` takes them; text, numbers, True, False, None and paths

    Raises what ``files.read`` raises, and FormatError where the child crashes, hangs or needs more memory. It costs
    some tenths of a second a file; :class:`Isolated` keeps its child for several.
    """
    with Isolated(timeout=timeout, memory=memory) as reader:
        return reader.read(path, **options)


class Isolated:
    """A child process that reads one file after another; started when it is needed, and again when it has died.

    Use it in a ``with`` block, or call :meth:`close`. Not for several threads at once.
    """

    def __init__(self, *, timeout: float = TIMEOUT, memory: int = MEMORY) -> None:
        if not (timeout > 0 and memory > 0):
            raise ParameterError(f"Expected timeout and memory > 0, got {timeout} s and {memory} bytes.")
        self.timeout = timeout
        self.memory = memory
        self._child: subprocess.Popen[bytes] | None = None

    def read(self, path: str | os.PathLike[str], **options: Any) -> Motion:
        """A motion, as ``files.read`` gives it; see :func:`read_isolated`."""
        motion = self._ask("read", path, options)
        assert isinstance(motion, Motion)
        return motion

    def read_recording(self, path: str | os.PathLike[str], **options: Any) -> Recording:
        """A recording, as ``files.read_recording`` gives it."""
        recording = self._ask("read_recording", path, options)
        assert isinstance(recording, Recording)
        return recording

    def close(self) -> None:
        """End the child."""
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            for pipe in (child.stdin, child.stdout):
                if pipe is not None:
                    try:
                        pipe.close()
                    except OSError:
                        continue
            child.wait()

    def __enter__(self) -> Isolated:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _ask(self, verb: str, path: str | os.PathLike[str], options: dict[str, Any]) -> Motion | Recording:
        request = {"verb": verb, "path": str(Path(path).absolute()), "memory": self.memory, "options": options}
        try:
            text = json.dumps(request, default=os.fspath).encode()
        except TypeError as error:
            raise ParameterError(f"Expected options of text, numbers and paths, got others: {error}.") from error
        with naming(path):
            answer, blobs = self._exchange(text)
        for message in answer.get("warnings", ()):
            warnings.warn(KinestitchWarning(message), stacklevel=4)
        if "error" in answer:
            raise _error(answer["error"], answer["message"], path)
        with naming(path):
            return value_of(answer, blobs)

    def _exchange(self, request: bytes) -> tuple[dict[str, Any], list[bytes]]:
        """Send a request and take the answer; a child that dies over it is cleared away."""
        if self._child is None or self._child.poll() is not None:
            self.close()
            self._child = _start()
        child = self._child
        late = threading.Event()

        def end() -> None:
            late.set()
            child.kill()

        timer = threading.Timer(self.timeout, end)
        timer.start()
        try:
            assert child.stdin is not None
            assert child.stdout is not None
            send(child.stdin, request, [])
            return receive(child.stdout, self.memory)
        except (OSError, EOFError, ValueError) as error:
            code = child.wait()
            self.close()
            if late.is_set():
                raise FormatError(
                    f"Expected to be read within {self.timeout:g} s, got no end. The file may be damaged; "
                    "else pass a longer timeout=."
                ) from error
            raise FormatError(
                f"Expected a readable file, got one that its reader crashes on ({_cause(code)}). It may be damaged."
            ) from error
        finally:
            timer.cancel()


def _start() -> subprocess.Popen[bytes]:
    paths = os.pathsep.join(entry for entry in sys.path if entry)
    environment = os.environ | _SINGLE | {"PYTHONPATH": paths, "MALLOC_ARENA_MAX": "2"}
    return subprocess.Popen(
        [sys.executable, "-m", "kinestitch.files.isolated_child"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
    )


def _cause(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"exit code {code}"


def _error(name: str, message: str, path: str | os.PathLike[str]) -> BaseException:
    """The child's error as one of the same kind; a reader's mistake stays recognisable as one."""
    kind: type[BaseException] = getattr(kinestitch.errors, name, getattr(builtins, name, RuntimeError))
    if kind is MemoryError:
        return FormatError(f"Expected to be read within the memory that is allowed, got more. Pass memory=. ({path})")
    if issubclass(kind, FileNotFoundError):
        return FileNotFoundError(2, "No such file or directory", str(path))
    if issubclass(kind, KinestitchError) or kind in (ValueError, TypeError, RuntimeError, OSError, PermissionError):
        return kind(message)
    return RuntimeError(f"{name}: {message} ({path})")
