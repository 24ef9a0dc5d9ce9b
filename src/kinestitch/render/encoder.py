"""Pictures in a row as an MP4 file that every browser plays: H.264 in yuv420p, its index in front."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.atomic import replacing
from kinestitch.errors import MissingExtraError

QUALITY = "18"
"""x264's constant rate factor: no loss that one sees on flat colours."""


def encoder_library() -> ModuleType:
    """PyAV; raises MissingExtraError with the command that installs it."""
    try:
        import av
    except ImportError as error:
        raise MissingExtraError(
            "Expected the library 'av' for videos, got none. Install it: pip install 'kinestitch[video]'"
        ) from error
    return av


@contextmanager
def encoding(
    path: str | os.PathLike[str], size: tuple[int, int], fps: float
) -> Iterator[Callable[[NDArray[np.uint8]], None]]:
    """A function that takes one picture (height, width, 4) RGBA after the other; the file appears when all are in.

    size : width and height, both even; fps : pictures a second

    Raises MissingExtraError without the encoder, OutputError where the file cannot be written.
    """
    av = encoder_library()
    with replacing(path) as stream, tempfile.TemporaryDirectory() as folder:
        draft = Path(folder) / "draft.mp4"
        with av.open(str(draft), "w", format="mp4", options={"movflags": "faststart"}) as container:
            track: Any = container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1001))
            track.width, track.height, track.pix_fmt = *size, "yuv420p"
            track.options = {"preset": "veryfast", "tune": "animation", "crf": QUALITY}
            _tell_colours(track.codec_context)

            def take(picture: NDArray[np.uint8]) -> None:
                frame = av.VideoFrame.from_ndarray(picture, format="rgba")
                frame = frame.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG")
                container.mux(track.encode(frame))

            yield take
            container.mux(track.encode())
        with draft.open("rb") as finished:
            shutil.copyfileobj(finished, stream)


def _tell_colours(context: Any) -> None:
    """BT.709, limited range: said in the file, so that no player has to guess."""
    context.colorspace = context.color_primaries = context.color_trc = 1
    context.color_range = 1
