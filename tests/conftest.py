"""What every test may use: Hypothesis profiles, and the real clips where there are some."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from kinestitch.core.motion import Motion
from kinestitch.files import read

settings.register_profile("default", deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("default"), derandomize=True, print_blob=True)
settings.register_profile("thorough", settings.get_profile("default"), max_examples=400)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE") or ("ci" if os.environ.get("CI") else "default"))


@pytest.fixture(scope="session")
def real_clip() -> Callable[[str], Motion]:
    """Reads a real clip by its path inside the folder of real clips, once; skips where there is no such folder."""
    folder = os.environ.get("KINESTITCH_DATA")
    if not folder:
        pytest.skip("KINESTITCH_DATA, the folder of real clips, is not set")
    return cache(lambda name: read(Path(folder) / name))


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Doctests are looked for in modules of the package only, not in the tests' own scripts."""
    name = collection_path.name
    return True if name.endswith(".py") and not name.startswith("test_") and name != "conftest.py" else None
