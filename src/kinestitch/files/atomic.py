"""The door of :mod:`kinestitch.core.atomic` for the readers and writers of this room."""

from kinestitch.core.atomic import replacing

__all__ = ["replacing"]
