"""The error tree: every error says what was expected, what was found, where, and what to try.

```
KinestitchError (Exception)
├── FormatError (ValueError)             a file is not what its suffix promises
├── UnsupportedFormatError (ValueError)  no reader or writer for this suffix
├── InvalidMotionError (ValueError)      arrays that are no motion
├── SkeletonMismatchError (ValueError)   two rigs that cannot share one result
├── RangeError (IndexError)              frames outside a clip or timeline, overlapping edits
├── DocumentError (ValueError)           an edit document that cannot be understood
├── ParameterError (ValueError)          a setting outside its domain (negative λ, fps 0)
├── MissingClipError (KeyError)          the timeline names a clip that was not given
├── MissingExtraError (ImportError)      an optional library is not installed
└── OutputError (OSError)                a file cannot be written
KinestitchWarning (UserWarning)          a recoverable oddity, counted
```
"""

from __future__ import annotations


class KinestitchError(Exception):
    """Base of all errors raised on purpose by kinestitch."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class FormatError(KinestitchError, ValueError):
    """A file is not what its suffix promises."""


class UnsupportedFormatError(KinestitchError, ValueError):
    """There is no reader or writer for this suffix."""


class InvalidMotionError(KinestitchError, ValueError):
    """Arrays that do not make a skeleton or a motion."""


class SkeletonMismatchError(KinestitchError, ValueError):
    """Two rigs that cannot share one result."""


class RangeError(KinestitchError, IndexError):
    """Frames outside a clip or timeline, empty ranges, overlapping edits."""


class DocumentError(KinestitchError, ValueError):
    """An edit document that cannot be understood."""


class ParameterError(KinestitchError, ValueError):
    """A setting outside its domain."""


class MissingClipError(KinestitchError, KeyError):
    """The timeline names a clip that was not given."""


class MissingExtraError(KinestitchError, ImportError):
    """An optional library is not installed; the message names the command that installs it."""


class OutputError(KinestitchError, OSError):
    """A file cannot be written."""


class KinestitchWarning(UserWarning):
    """A recoverable oddity in the input; the message carries a count."""
