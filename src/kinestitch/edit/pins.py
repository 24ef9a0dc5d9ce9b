"""Where the body has to be: pins on frames of the result, and how they are written on a command line."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from kinestitch.errors import ParameterError, RangeError

PinKind = Literal["root", "heading", "waypoint", "return", "position", "rotation"]
KINDS: tuple[PinKind, ...] = get_args(PinKind)
_NUMBERS = {"root": 3, "heading": 1, "waypoint": 2, "return": 0, "position": 3, "rotation": 4}
_FIXES = {
    "root": ("place",),
    "heading": ("heading",),
    "waypoint": ("place",),
    "return": ("place", "heading"),
    "position": ("position",),
    "rotation": ("rotation",),
}
_UNIT = 1e-2  # by which a quaternion written by hand may be off unit norm


@dataclass(frozen=True, slots=True)
class Pin:
    """What one frame of the result has to show.

    kind, target : ``root`` (x, y, z) m, the point on the ground below the hips, y how much higher than solved the body
        stands there; ``heading`` (rad,), 0 faces +Z, a quarter turn +X; ``waypoint`` (x, z) m, through which the path
        is bent; ``return`` (), from here on the body is where its own clip has it; ``position`` (x, y, z) m of a joint
        in the world; ``rotation`` (x, y, z, w) of a joint, local
    frame : of the result; joint : for the last two kinds
    weight : infinity is exact; a lone pin of weight w goes w / (w + 1) of the way
    smoothing : s, how gently the pin is reached and left; of a ``return``, how long the way back takes; None is the
        kind's own

    Raises ParameterError for values out of their domain.
    """

    kind: PinKind
    frame: int
    target: tuple[float, ...] = ()
    joint: str | None = None
    weight: float = math.inf
    smoothing: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ParameterError(f"Expected a pin out of {', '.join(KINDS)}, got {self.kind!r}.")
        try:
            object.__setattr__(self, "frame", operator.index(self.frame))
        except TypeError as error:
            raise ParameterError(f"Expected a whole number for a pin's frame, got {self.frame!r}.") from error
        object.__setattr__(self, "target", tuple(_number(value, "a pin's target") for value in self.target))
        object.__setattr__(self, "weight", _number(self.weight, "a pin's weight", math.inf))
        if self.smoothing is not None:
            object.__setattr__(self, "smoothing", _number(self.smoothing, "a pin's smoothing time"))
        self._check()

    def _check(self) -> None:
        told = f"the pin {self.kind} on frame {self.frame}"
        if len(self.target) != _NUMBERS[self.kind]:
            raise ParameterError(f"Expected {_NUMBERS[self.kind]} numbers for {told}, got {len(self.target)}.")
        if (self.joint is not None) != (self.kind in ("position", "rotation")):
            found = "none" if self.joint is None else repr(self.joint)
            raise ParameterError(f"Expected {'a' if self.joint is None else 'no'} joint for {told}, got {found}.")
        if self.joint is not None and not isinstance(self.joint, str):
            raise ParameterError(f"Expected a joint's name for {told}, got {self.joint!r}.")
        if not self.weight > 0:
            raise ParameterError(f"Expected a weight > 0 for {told}, got {self.weight:g}.")
        if self.smoothing is not None and not self.smoothing > 0:
            raise ParameterError(f"Expected a smoothing time > 0 s for {told}, got {self.smoothing:g}.")
        if self.kind == "rotation" and abs(math.hypot(*self.target) - 1) > _UNIT:
            raise ParameterError(
                f"Expected a quaternion x,y,z,w of length 1 for {told}, got one of {math.hypot(*self.target):.4g}."
            )
        if self.kind == "return" and (self.smoothing is None or self.weight != math.inf):
            raise ParameterError(f"Expected a time for the way back and no weight for {told}.")

    @property
    def exact(self) -> bool:
        """Whether it has to be met, rather than neared."""
        return self.weight == math.inf

    @property
    def fixes(self) -> frozenset[tuple[str, str | None]]:
        """What it decides; two pins of one frame decide different things."""
        return frozenset((what, self.joint) for what in _FIXES[self.kind])

    def __str__(self) -> str:
        """As on a command line."""
        numbers = [math.degrees(value) for value in self.target] if self.kind == "heading" else self.target
        name = self.kind if self.joint is None else self.joint
        values = "" if self.kind == "return" else "=" + ",".join(f"{value:.6g}" for value in numbers)
        return f"{name}@{self.frame}{values}" + ("" if self.exact else f":{self.weight:g}")


def _number(value: float, what: str, most: float = 1e9) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"Expected a number for {what}, got {value!r}.") from error
    if not -1e9 <= number <= most:
        raise ParameterError(f"Expected a finite number for {what}, got {number}.")
    return number + 0.0


def check_pins(pins: Sequence[Pin], frames: int) -> None:
    """Raise RangeError for a frame outside the result, ParameterError for two pins that decide one thing in one
    frame.
    """
    taken: dict[tuple[int, tuple[str, str | None]], Pin] = {}
    for pin in pins:
        if not 0 <= pin.frame < frames:
            raise RangeError(f"Expected a pin on one of the result's frames 0 to {frames - 1}, got {pin}.")
        for what in pin.fixes:
            other = taken.setdefault((pin.frame, what), pin)
            if other is not pin:
                raise ParameterError(f"Expected one pin for the {what[0]} in frame {pin.frame}, got {other} and {pin}.")


def away_again(pins: Sequence[Pin]) -> str:
    """A sentence where a pin leads the body away from the path that the last return has led it back to; empty where
    none does.

    pins : in the order of their frames
    """
    home = next((pin for pin in reversed(pins) if pin.kind == "return"), None)
    if home is None:
        return ""
    behind = [pin for pin in pins if pin.frame > home.frame and pin.kind in ("root", "heading", "waypoint")]
    if not behind:
        return ""
    return (
        f"{home} leads back to the original path, and {behind[0]} behind it away from it again. Put the pin on a frame "
        f"before {home.frame}, or leave one of them out."
    )


def sorted_pins(pins: Sequence[Pin]) -> tuple[Pin, ...]:
    """In the order of their frames, so that timelines with the same pins are equal."""
    return tuple(sorted(pins, key=lambda pin: (pin.frame, KINDS.index(pin.kind), pin.joint or "")))


_PIN = re.compile(r"(?P<name>.+)@(?P<frame>[0-9]{1,15})=(?P<numbers>[^:]+)(?::(?P<weight>[^:]+))?", re.DOTALL)


def parse_pin(text: str) -> Pin:
    """A pin as it is written: ``root@120=1.2,0,3.4``, ``heading@120=90`` (degrees), ``LeftHand@80=x,y,z`` (world, m) or
    ``LeftHand@80=x,y,z,w`` (local rotation), each with ``:weight`` behind it if it need not be exact.

    Raises ParameterError for anything else.

    >>> parse_pin("root@120=1.2,0,3.4:5")
    Pin(kind='root', frame=120, target=(1.2, 0.0, 3.4), joint=None, weight=5.0, smoothing=None)
    """
    match = _PIN.fullmatch(text.strip())
    if match is None:
        raise ParameterError(f"Expected a pin such as root@120=1.2,0,3.4 or LeftHand@80=0.3,1.4,0.5:2, got {text!r}.")
    name, frame, numbers = match["name"], int(match["frame"]), _floats(match["numbers"], text)
    weight = math.inf if match["weight"] is None else _floats(match["weight"], text, 1)[0]
    if name == "heading":
        return Pin("heading", frame, tuple(map(math.radians, numbers)), weight=weight)
    if name == "root":
        return Pin("root", frame, numbers, weight=weight)
    if len(numbers) not in (3, 4):
        raise ParameterError(
            f"Expected 3 numbers (a joint's position in m) or 4 (its rotation x,y,z,w), got {len(numbers)} in {text!r}."
        )
    return Pin("position" if len(numbers) == 3 else "rotation", frame, numbers, name, weight)


def parse_waypoint(text: str) -> Pin:
    """A waypoint as it is written: ``120=1.2,3.4``, maybe with ``:weight``; raises ParameterError for anything else.

    >>> str(parse_waypoint("120=1.2,3.4"))
    'waypoint@120=1.2,3.4'
    """
    match = _PIN.fullmatch("waypoint@" + text.strip())
    if match is None or match["name"] != "waypoint":
        raise ParameterError(f"Expected a waypoint FRAME=X,Z such as 120=1.2,3.4, got {text!r}.")
    weight = math.inf if match["weight"] is None else _floats(match["weight"], text, 1)[0]
    return Pin("waypoint", int(match["frame"]), _floats(match["numbers"], text), weight=weight)


def _floats(words: str, text: str, count: int | None = None) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in words.split(","))
    except ValueError:
        numbers = ()
    if not numbers or not all(map(math.isfinite, numbers)) or count not in (None, len(numbers)):
        raise ParameterError(f"Expected numbers with commas between them, got {words!r} in {text!r}.")
    return numbers
