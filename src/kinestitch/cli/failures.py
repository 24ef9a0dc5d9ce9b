"""Whatever goes wrong becomes one line on stderr and an exit code; a traceback only where somebody asks for it."""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import click

from kinestitch.errors import KinestitchError, KinestitchWarning

TRACEBACK = "KINESTITCH_TRACEBACK"
"""Set this environment variable to see where an error came from."""

WRONG, STOPPED = 2, 130


class Stopped(Exception):  # noqa: N818 (no error, a wish)
    """The user pressed Ctrl-C."""


def run(command: click.Command, arguments: Sequence[str] | None) -> int:
    """Run a command; returns 0, 2 after an error or 130 after Ctrl-C, having told why in one line on stderr."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a file's name may be no text, or λ beyond the terminal
    try:
        with warnings_as_lines(lambda text: tell("warning", text)):
            code = command.main(arguments, prog_name="kinestitch", standalone_mode=False)
        return code if isinstance(code, int) else 0
    except (Stopped, KeyboardInterrupt, click.Abort):
        tell("error", "Stopped before the end.")
        return STOPPED
    except Exception as error:
        if os.environ.get(TRACEBACK):
            traceback.print_exc()
        if _asked_for_help(error):
            click.echo(str(error), err=True)
        else:
            tell("error", explain(error))
        return WRONG


def tell(kind: str, text: str) -> None:
    """One line ``kind: text`` on stderr."""
    click.echo(f"{kind}: {' '.join(text.splitlines())}", err=True)


def explain(error: BaseException) -> str:
    """What was expected, what was found, where, and what to try."""
    if isinstance(error, KinestitchError):
        return str(error)
    if isinstance(error, click.ClickException):
        return _explain_usage(error)
    if isinstance(error, OSError):
        return _explain_system(error)
    if isinstance(error, MemoryError):
        return "Expected enough memory, got too little. Use shorter clips or a lower frame rate."
    return f"Expected no fault of our own, got {type(error).__name__}: {error}. Set {TRACEBACK}=1 to see where."


@contextmanager
def warnings_as_lines(show: Callable[[str], None]) -> Iterator[None]:
    """Inside, every warning is passed to `show` as one line, and each time it is given."""

    def showwarning(message: Warning | str, *_: Any, **__: Any) -> None:
        show(str(message))

    with warnings.catch_warnings():
        warnings.simplefilter("always", KinestitchWarning)
        warnings.showwarning = showwarning
        yield


def _asked_for_help(error: Exception) -> bool:
    return type(error).__name__ == "NoArgsIsHelpError"  # click 8.1 does not have it


def _explain_usage(error: click.ClickException) -> str:
    message = error.format_message()
    context = getattr(error, "ctx", None)
    path = context.command_path if context is not None else "kinestitch"
    return f"{message} Try '{path} --help'."


def _explain_system(error: OSError) -> str:
    place = f" ({error.filename})" if error.filename else ""
    if isinstance(error, FileNotFoundError):
        return f"Expected a file, got nothing of this name. Check the path.{place}"
    if isinstance(error, IsADirectoryError):
        return f"Expected a file, got a folder. Name a file in it.{place}"
    if isinstance(error, PermissionError):
        return f"Expected a file that you may use, got no permission. Change its owner or mode.{place}"
    return f"Expected to read or write, got: {error.strerror or error}.{place}"
