"""The verb ``reproduce``: the paper's figures and claims, computed anew, as one report."""

from __future__ import annotations

from pathlib import Path

import click

from kinestitch.cli.console import console, progress
from kinestitch.cli.options import FILE

_STEPS = 13


@click.command(short_help="Compute the paper's figures and claims anew.")
@click.argument("data", metavar="[DATA_DIR]", required=False, type=FILE)
@click.option("-o", "--output", required=True, type=FILE, metavar="DIR", help="Where the report goes.")
@click.option("--docs", type=FILE, metavar="DIR", help="Where results.md and results.json go instead.")
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Makes the run repeatable.")
@click.option("--quick", is_flag=True, help="A few cuts only, to see that everything works.")
def reproduce(*, data: str | None, output: str, docs: str | None, seed: int, quick: bool) -> None:
    """Run every experiment on the clips of DATA_DIR and write one report, report.html and report.pdf.

    DATA_DIR holds one folder of clips per data set (mixamo_xbot_60fps, bandai, cmu). Without it, the generated samples
    stand in, and the report says so. Blender's part needs a Python that can import bpy (make setup-blender).

    \b
    Examples:
      kinestitch reproduce clips -o out
      kinestitch reproduce --quick -o out
    """
    with progress(_STEPS) as step:
        step("loading")
        from kinestitch.experiments.reproduce import check_folder, write_report
        from kinestitch.experiments.reproduce import reproduce as run

        folder = None if data is None else Path(data)
        if folder is not None:
            check_folder(folder)
        report = run(folder, quick=quick, seed=seed, progress=lambda name: step(name or "writing"))
        made = write_report(report, Path(output), docs=None if docs is None else Path(docs))
    out = console()
    for section in report.sections:
        for finding in section.findings:
            out.print(f"{finding.verdict}: {finding.claim} {finding.evidence}")
    for target in made:
        out.print(target)
