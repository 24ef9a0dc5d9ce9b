"""Random timelines, and what a timeline shows frame by frame: the plain list every property is checked on."""

from __future__ import annotations

from hypothesis import strategies as st

from kinestitch.edit.pins import Pin
from kinestitch.edit.retiming import Retiming
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline

RATES = (24.0, 29.97, 30.0, 60.0, 120.0, 1 / 0.0333333)


def labels(timeline: Timeline) -> list[tuple[str, int]]:
    """(clip, frame of the clip at the timeline's rate) of each frame of the result."""
    return [(s.clip, frame) for s in timeline.segments for frame in range(s.range.start, s.range.stop)]


def seams() -> st.SearchStrategy[Seam]:
    size = st.floats(0, 1e6, allow_nan=False)
    return st.one_of(
        st.sampled_from([Seam(), Seam(automatic=True)]),
        size.map(lambda x: Seam(stiffness=x)),
        st.floats(0, 5).map(lambda x: Seam(smoothing=x)),
    )


def pinned_labels(timeline: Timeline) -> list[tuple[tuple[str, int], tuple[Pin, ...]]]:
    """The labels, each with the pins of its frame, these told without the frame."""
    from dataclasses import replace

    pins: dict[int, list[Pin]] = {}
    for pin in timeline.pins:
        pins.setdefault(pin.frame, []).append(replace(pin, frame=0))
    return [(label, tuple(pins.get(frame, ()))) for frame, label in enumerate(labels(timeline))]


@st.composite
def pins(draw: st.DrawFn, frames: int) -> Pin:
    """A pin of any kind on one of so many frames."""
    frame = draw(st.integers(0, frames - 1))
    number = st.floats(-1e6, 1e6)
    weight = draw(st.just(float("inf")) | st.floats(1e-6, 1e6))
    smoothing = draw(st.none() | st.floats(1e-3, 5))
    kind = draw(st.sampled_from(["root", "heading", "waypoint", "return", "position", "rotation"]))
    if kind == "return":
        return Pin(kind, frame, smoothing=smoothing or 1.0)
    joint = draw(st.sampled_from(["LeftHand", "mixamorig:Head"])) if kind in ("position", "rotation") else None
    count = {"root": 3, "heading": 1, "waypoint": 2, "position": 3}.get(kind)
    unit = st.sampled_from([(0.0, 0.0, 0.6, 0.8), (0.5, -0.5, 0.5, 0.5), (1 / 3, 2 / 3, 2 / 3, 0.0)])
    target = draw(unit) if count is None else tuple(draw(number) for _ in range(count))
    return Pin(kind, frame, target, joint, weight, smoothing)


def agreeing(found: list[Pin]) -> tuple[Pin, ...]:
    """Without those that decide what one before them decides."""
    kept: list[Pin] = []
    for pin in found:
        if not any(pin.frame == other.frame and pin.fixes & other.fixes for other in kept):
            kept.append(pin)
    return tuple(kept)


@st.composite
def retimed(draw: st.DrawFn, source: ClipInfo, key: str) -> ClipInfo:
    """A clip that shows some stretch of another at speeds from 0.2 to 4."""
    steps = draw(st.lists(st.tuples(st.floats(0.05, 2.0), st.floats(0.2, 4.0)), min_size=1, max_size=5))
    times, shown = [0.0], [draw(st.floats(0.0, 1.0))]
    for length, speed in steps:
        times.append(times[-1] + length)
        shown.append(shown[-1] + length * speed)
    scale = draw(st.floats(0.5, 1.0)) * (source.frames - 1) / source.fps / shown[-1]
    retiming = Retiming(source.key, tuple((a * scale, b * scale) for a, b in zip(times, shown, strict=True)))
    return ClipInfo(key, retiming.frames_at(source.fps), source.fps, retiming)


@st.composite
def timelines(draw: st.DrawFn, *, most_frames: int = 40, rates: tuple[float, ...] = RATES) -> Timeline:
    fps = draw(st.sampled_from(rates))
    keys = draw(
        st.lists(
            st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=6),
            min_size=1,
            max_size=4,
            unique=True,
        )
    )
    size = st.integers(1, most_frames)
    clips = tuple(ClipInfo(key, draw(size), draw(st.sampled_from(rates))) for key in keys)
    long = [clip for clip in clips if 2 <= clip.frames <= 10**9]
    for number in range(draw(st.integers(0, 2)) if long else 0):
        clips = (*clips, draw(retimed(draw(st.sampled_from(long)), f"retimed {number}")))

    def segment(info: ClipInfo) -> Segment:
        frames = info.frames_at(fps)
        start = draw(st.integers(0, frames - 1))
        return Segment(info.key, FrameRange(start, draw(st.integers(start + 1, frames))))

    count = draw(st.integers(1, 5))
    segments = tuple(segment(draw(st.sampled_from(clips))) for _ in range(count))
    frames = sum(map(len, segments))
    pinned = agreeing(draw(st.lists(pins(frames), max_size=3)))
    return Timeline(clips, segments, tuple(draw(seams()) for _ in range(count - 1)), fps, pinned, draw(st.booleans()))


def spans(timeline: Timeline) -> st.SearchStrategy[tuple[int, int]]:
    """Non-empty ranges of its frames."""
    bounds = st.integers(0, timeline.frames)
    return st.tuples(bounds, bounds).filter(lambda pair: pair[0] != pair[1]).map(lambda pair: (min(pair), max(pair)))
