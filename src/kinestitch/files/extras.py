"""Libraries that not everybody needs: imported when a file asks for them."""

from __future__ import annotations

import importlib
from types import ModuleType

from kinestitch.errors import MissingExtraError


def optional(module: str, extra: str) -> ModuleType:
    """Import a library of the package's extra; raises MissingExtraError with the command that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        library = module.partition(".")[0]
        raise MissingExtraError(
            f"Expected the library {library!r}, got none. Install it: pip install 'kinestitch[{extra}]'"
        ) from error
