"""Damaged files against every reader: each has to read or refuse them, within 10 s and 1 GiB, and never crash.

    python tests/fuzz/run.py [NAME ...] [--count 10000] [--seed 0] [--no-corpus]

Replays the corpus, then that many fresh inputs a reader, in worker processes that start anew every few hundred. Cases
that go wrong are kept in tests/fuzz/corpus. Ends with 1 if there are any.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from targets import TARGETS

HERE = Path(__file__).parent
CORPUS = HERE / "corpus"
SECONDS = 60.0
"""Until a worker is given up that waits for something; one that works is ended after 10 s (see worker.py)."""
INPUTS_A_WORKER = 500


class Worker:
    """A process that reads; started anew when it has died or read enough."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name, self.folder, self.done = name, folder, 0
        self.process: subprocess.Popen[str] | None = None

    def ask(self, order: dict[str, str]) -> tuple[str, str]:
        """How it went, and what went wrong."""
        if self.process is None or self.done >= INPUTS_A_WORKER:
            self.close()
            self._start()
        process = self.process
        assert process is not None
        self.done += 1
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
            ready, _, _ = select.select([process.stdout], [], [], SECONDS)
            line = process.stdout.readline() if ready else None
        except OSError:
            line = ""
        if line:
            answer = json.loads(line)
            return answer["how"], answer["what"]
        what = f"no answer within {SECONDS:g} s" if line is None else _death(self._code())
        self.close()
        return "wrong", what

    def _start(self) -> None:
        single = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, str(HERE / "worker.py"), self.name, str(self.folder)]
        self.done = 0
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=os.environ | single
        )

    def _code(self) -> int | None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self.process.wait(2)
        return None

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.stdin.close()
            self.process.stdout.close()
            self.process.wait()
            self.process = None


def fuzz(name: str, count: int, seed: str, *, corpus: bool) -> tuple[Counter[str], list[str]]:
    """Numbers of inputs by how they went, and what went wrong."""
    counts: Counter[str] = Counter()
    findings: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder:
        worker = Worker(name, Path(folder))
        try:
            for path in sorted((CORPUS / name).glob("*")) if corpus else ():
                how, what = worker.ask({"file": str(path)})
                counts[how] += 1
                if how == "wrong":
                    findings.setdefault(_kind(what), f"{path.name}: {what}")
            for index in range(count):
                how, what = worker.ask({"seed": f"{seed}/{name}/{index}"})
                counts[how] += 1
                if how == "wrong" and _kind(what) not in findings:
                    findings[_kind(what)] = f"{keep(name, Path(folder))}: {what}"
        finally:
            worker.close()
    return counts, [f"{name}: {case}" for case in findings.values()]


def _death(code: int | None) -> str:
    return "more than 10 s of work" if code == -signal.SIGPROF else f"the process died ({code})"


def _kind(what: str) -> str:
    """What findings of one cause have in common: the error and its place, not the numbers in its message."""
    return what.split(":", maxsplit=1)[0] + (what[what.rfind("(") :] if what.endswith(")") else "")


def keep(name: str, folder: Path) -> str:
    """Put the file that a worker stumbled over into the corpus; returns its name there."""
    case = next(folder.glob("case*"))
    (CORPUS / name).mkdir(parents=True, exist_ok=True)
    number = 1 + sum(1 for _ in (CORPUS / name).iterdir())
    target = CORPUS / name / f"found_{number:03d}{case.suffix}"
    target.write_bytes(case.read_bytes())
    return target.name


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"out of {', '.join(TARGETS)}; all when left out")
    parser.add_argument("--count", type=int, default=10_000, help="fresh inputs a reader")
    parser.add_argument("--seed", default="0", help="another seed makes other inputs")
    parser.add_argument("--no-corpus", action="store_true")
    chosen = parser.parse_args()
    findings: list[str] = []
    for name in chosen.names or TARGETS:
        begun = time.perf_counter()
        counts, wrong = fuzz(name, chosen.count, chosen.seed, corpus=not chosen.no_corpus)
        took = time.perf_counter() - begun
        told = ", ".join(f"{counts[how]} {how}" for how in ("read", "refused", "wrong"))
        print(f"{name}: {sum(counts.values())} inputs, {told}, {took:.0f} s", flush=True)
        findings += wrong
    print("\n".join(findings), end="\n" if findings else "")
    return bool(findings)


if __name__ == "__main__":
    sys.exit(main())
