"""Reads damaged files and tells how it went, one line each. Started, watched and ended by run.py.

    python worker.py NAME FOLDER

Each line of its input is a JSON object {"seed": text} (a fresh damaged file) or {"file": path}. Each answer is a JSON
object with "how": "read", "refused" or "wrong", and "what" went wrong. The file that is being read stands in FOLDER.
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import sys
import traceback
import warnings
from pathlib import Path

MEMORY = 1 << 30
SECONDS = 10.0
"""Of the processor's time, so that a busy machine is not blamed on a file; the kernel ends what takes longer."""


def main(name: str, folder: Path) -> None:
    answers = os.fdopen(os.dup(1), "w")
    printed = os.open(folder / "printed.txt", os.O_RDWR | os.O_CREAT | os.O_TRUNC)
    os.dup2(printed, 1)
    os.dup2(printed, 2)

    from mutations import mutate
    from targets import TARGETS

    target = TARGETS[name]
    seeds = list(target.seeds())
    contents = [data for _, data in seeds]
    if not target.native:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for line in sys.stdin:
        order = json.loads(line)
        if "seed" in order:
            suffix, data = random.Random(order["seed"]).choice(seeds)
            path = folder / f"case{suffix}"
            path.write_bytes(mutate(data, contents, order["seed"], target.change))
        else:
            path = Path(order["file"])
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        how, what = attempt(target.read, path)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        if os.fstat(printed).st_size:
            os.lseek(printed, 0, os.SEEK_SET)
            how, what = "wrong", "printed " + os.read(printed, 200).decode("utf-8", "replace")
            os.ftruncate(printed, 0)
            os.lseek(printed, 0, os.SEEK_SET)
        answers.write(json.dumps({"how": how, "what": what, "path": str(path)}) + "\n")
        answers.flush()


def attempt(read, path: Path) -> tuple[str, str]:
    """How reading went: ("read", ""), ("refused", message) or ("wrong", what)."""
    from kinestitch.errors import KinestitchError, KinestitchWarning

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", KinestitchWarning)
        try:
            read(path)
        except KinestitchError as error:
            if "\n" in str(error):
                return "wrong", f"a message of several lines: {error}"
            return "refused", str(error)
        except BaseException as error:  # this is what we are looking for
            where = traceback.extract_tb(error.__traceback__)[-1]
            return "wrong", f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
    return "read", ""


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
