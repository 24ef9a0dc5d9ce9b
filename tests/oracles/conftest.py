"""Other programs to ask: each lives in an environment of its own beside the checkout (see setup.sh)."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def _python(environment):
    python = ROOT / environment / "bin" / "python"
    if not python.exists():
        reason = f"{environment} is missing; tests/oracles/setup.sh makes it"
        if os.environ.get("KINESTITCH_ORACLES") == "1":
            pytest.fail(reason)
        pytest.skip(reason)
    return python


def _asker(environment, script, folder):
    def ask(requests):
        """Answers (dicts of arrays, or with a text `error`) to a list of requests, in order."""
        python = _python(environment)
        rows = [
            {**entry, "path": str(entry["path"]), "out": str(folder / f"{i}.npz")} for i, entry in enumerate(requests)
        ]
        for row in rows:
            Path(row["out"]).unlink(missing_ok=True)
        report = ""
        for _ in range(3):  # a crash of the other program costs its own file only
            left = [row for row in rows if not Path(row["out"]).exists()]
            if not left:
                break
            (folder / "requests.json").write_text(json.dumps(left))
            command = [str(python), str(HERE / script), str(folder / "requests.json")]
            report = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False).stderr[-500:]
        missing = [row["path"] for row in rows if not Path(row["out"]).exists()]
        assert not missing, f"{script} gave no answer about {missing}: {report}"
        return [dict(np.load(row["out"])) for row in rows]

    return ask


@pytest.fixture(scope="session")
def ask_ufbx(tmp_path_factory):
    return _asker(".venv-ufbx", "ask_ufbx.py", tmp_path_factory.mktemp("ufbx"))


@pytest.fixture(scope="session")
def ask_blender(tmp_path_factory):
    return _asker(".venv-bpy", "ask_blender.py", tmp_path_factory.mktemp("blender"))


@pytest.fixture(scope="session")
def blender_python():
    """The Python that can import bpy."""
    return _python(".venv-bpy")
