"""What a measurement is that has no skeleton yet: markers in space, and analog channels beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import frozen
from kinestitch.errors import InvalidMotionError


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """One trial of a laboratory: M markers over F frames, C analog channels over S samples.

    markers : (F, M, 3) m, world, right-handed with Y up; all three NaN where a marker was not seen
    marker_names : M unique names
    rate : frames a second of the markers, > 0
    analog : (S, C) in the channels' own units
    analog_names, analog_units : C unique names, and C units as the file writes them (``"V"``, ``"N"``, ``""``)
    analog_rate : samples a second, > 0; both clocks start together
    name : what a person calls the trial

    Arrays are read-only. Raises InvalidMotionError for shapes that disagree, repeated names, infinities, markers that
    are NaN in part, and rates ≤ 0.
    """

    markers: Array
    marker_names: tuple[str, ...]
    rate: float
    analog: Array
    analog_names: tuple[str, ...]
    analog_units: tuple[str, ...]
    analog_rate: float
    name: str = ""

    def __post_init__(self) -> None:
        for field in ("markers", "analog"):
            object.__setattr__(self, field, frozen(getattr(self, field)))
        for field in ("marker_names", "analog_names", "analog_units"):
            object.__setattr__(self, field, tuple(str(name) for name in getattr(self, field)))
        for field in ("rate", "analog_rate"):
            object.__setattr__(self, field, float(getattr(self, field)))
            if not (np.isfinite(getattr(self, field)) and getattr(self, field) > 0):
                raise InvalidMotionError(f"Expected {field} > 0, got {getattr(self, field)}.")
        self._check_shapes()
        self._check_values()

    def _check_shapes(self) -> None:
        if self.markers.ndim != 3 or self.markers.shape[1:] != (len(self.marker_names), 3):
            raise InvalidMotionError(
                f"Expected markers of shape (F, {len(self.marker_names)}, 3), got {self.markers.shape}."
            )
        if self.analog.ndim != 2 or self.analog.shape[1] != len(self.analog_names):
            raise InvalidMotionError(
                f"Expected analog of shape (S, {len(self.analog_names)}), got {self.analog.shape}."
            )
        if len(self.analog_units) != len(self.analog_names):
            raise InvalidMotionError(f"Expected {len(self.analog_names)} analog units, got {len(self.analog_units)}.")
        for what, names in (("marker", self.marker_names), ("analog", self.analog_names)):
            if len(set(names)) != len(names):
                twice = next(name for name in names if names.count(name) > 1)
                raise InvalidMotionError(f"Expected unique {what} names, got {twice!r} more than once.")

    def _check_values(self) -> None:
        if np.isinf(self.markers).any() or np.isinf(self.analog).any():
            raise InvalidMotionError("Expected numbers or NaN in markers and analog, got infinity.")
        missing = np.isnan(self.markers).sum(axis=-1)
        if not np.isin(missing, (0, 3)).all():
            frame, marker = np.argwhere(~np.isin(missing, (0, 3)))[0]
            raise InvalidMotionError(
                f"Expected markers that are seen whole or not at all, got {self.markers[frame, marker]} "
                f"at frame {frame}, marker {self.marker_names[marker]!r}."
            )

    @property
    def frames(self) -> int:
        """Number of frames F of the markers."""
        return self.markers.shape[0]

    @property
    def samples(self) -> int:
        """Number of samples S of the analog channels."""
        return self.analog.shape[0]

    @property
    def duration(self) -> float:
        """Seconds that the longer of both clocks covers: F / rate or S / analog_rate."""
        return max(self.frames / self.rate, self.samples / self.analog_rate)
