"""Undo: keeping the old values. A drag of a hundred messages is one step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from kinestitch.errors import ParameterError

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class History(Generic[T]):
    """What was, what is, and what was undone; a value itself, so that old histories stay as they were.

    past : oldest first, at most `limit` steps
    present : the last committed value
    future : the next redo first
    held : what a drag shows before it is committed; one value or none
    limit : how many steps are kept

    >>> history = History(present="walk")
    >>> for length in range(100):
    ...     history = preview(history, f"walk and {length} frames of kick")
    >>> history = commit(history, "walk and kick")
    >>> history.value, undo(history).value, redo(undo(history)) == history
    ('walk and kick', 'walk', True)
    """

    present: T
    past: tuple[T, ...] = ()
    future: tuple[T, ...] = ()
    held: tuple[T, ...] = ()
    limit: int = 200

    def __post_init__(self) -> None:
        if self.limit < 1:
            raise ParameterError(f"Expected a limit of at least 1 step, got {self.limit}.")
        if len(self.held) > 1:
            raise ParameterError(f"Expected at most one held value, got {len(self.held)}.")
        object.__setattr__(self, "past", tuple(self.past)[-self.limit :])

    @property
    def value(self) -> T:
        """What is to be shown: the held value during a drag, else the present one."""
        return self.held[0] if self.held else self.present


def preview(history: History[T], value: T) -> History[T]:
    """Show a value without making a step of it: each message of a drag replaces the one before."""
    return replace(history, held=(value,))


def commit(history: History[T], value: T) -> History[T]:
    """Make a value the present one, one step after what was committed last; there is nothing left to redo.

    A value equal to the present one makes no step: it only ends the drag.
    """
    if value == history.present:
        return replace(history, held=())
    return replace(history, past=(*history.past, history.present), present=value, future=(), held=())


def undo(history: History[T]) -> History[T]:
    """One step back; during a drag only the drag is dropped. Without a past nothing happens."""
    if history.held:
        return replace(history, held=())
    if not history.past:
        return history
    return replace(history, past=history.past[:-1], present=history.past[-1], future=(history.present, *history.future))


def redo(history: History[T]) -> History[T]:
    """One undone step forward again; a drag is dropped. Without a future nothing happens but that."""
    history = replace(history, held=())
    if not history.future:
        return history
    return replace(history, past=(*history.past, history.present), present=history.future[0], future=history.future[1:])
