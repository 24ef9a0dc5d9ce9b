"""What the command line tells about itself, and what it costs to ask."""

from __future__ import annotations

import os
import pty
import subprocess
import sys

import pytest

from kinestitch import __version__
from kinestitch.cli import VERBS


def python(code: str, **environment: str) -> str:
    """Output of a fresh interpreter."""
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ, **environment}
    )
    return ran.stdout


HEAVY = ("numpy", "scipy", "matplotlib", "opentimelineio", "rich")


@pytest.mark.parametrize("words", [["--help"], ["--version"], [], *([verb, "--help"] for verb in VERBS)])
def test_help_loads_nothing_heavy(words):
    code = f"""
import sys
from kinestitch.cli import main
main({words!r})
print("LOADED", [name for name in {HEAVY!r} if name in sys.modules])
"""
    assert python(code).splitlines()[-1] == "LOADED []"


def test_the_package_itself_loads_nothing_heavy():
    code = f"""
import sys
import kinestitch
dir(kinestitch)
print([name for name in {HEAVY!r} + ("click", "kinestitch.core") if name in sys.modules])
"""
    assert python(code) == "[]\n"


def test_help_lists_every_verb_and_examples(kinestitch):
    told = kinestitch("--help")
    assert told.code == 0
    for verb in VERBS:
        assert f"\n  {verb} " in told.out
        page = kinestitch(verb, "-h")
        assert page.code == 0
        assert f"Usage: kinestitch {verb}" in page.out
        assert f"\n    kinestitch {verb}" in page.out or verb == "completion"  # an example
        assert max(map(len, page.out.splitlines())) <= 100


def test_version(kinestitch):
    assert kinestitch("--version").out == f"kinestitch {__version__}\n"


def test_as_a_module():
    ran = subprocess.run([sys.executable, "-m", "kinestitch", "--version"], capture_output=True, text=True, check=True)
    assert ran.stdout == f"kinestitch {__version__}\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_prints_a_script(kinestitch, shell):
    ran = kinestitch("completion", shell)
    assert ran.code == 0
    assert "_KINESTITCH_COMPLETE" in ran.out


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("kinestitch st", ["plain,stitch"]),
        ("kinestitch stitch --re", ["plain,--replace", "plain,--return", "plain,--report"]),
        ("kinestitch stitch --method c", ["plain,cut"]),
        ("kinestitch stitch --append ki", ["file,ki"]),
        ("kinestitch stitch --replace 1:2 ki", ["file,ki"]),
        ("kinestitch info ki", ["file,ki"]),
    ],
)
def test_the_tab_key(line, offered):
    code = "from kinestitch.cli import main; main([])"
    words = {"COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    assert python(code, _KINESTITCH_COMPLETE="bash_complete", **words).split() == offered


BAR = """
import sys, time
import kinestitch.cli.console as console
console.PATIENCE = {patience}
with console.progress(4) as step:
    step("reading [a:b].bvh")
    time.sleep(0.3)
    step("solving")
"""


def on_a_terminal(code: str) -> str:
    """What a program writes to stderr when that is a terminal."""
    ours, theirs = pty.openpty()
    with subprocess.Popen([sys.executable, "-c", code], stderr=theirs, env={**os.environ, "TERM": "xterm"}) as process:
        os.close(theirs)
        written = b""
        while True:
            try:
                chunk = os.read(ours, 4096)
            except OSError:
                break
            if not chunk:
                break
            written += chunk
    os.close(ours)
    assert process.returncode == 0
    return written.decode()


def test_a_bar_shows_what_takes_long():
    assert "reading [a:b].bvh" in on_a_terminal(BAR.format(patience=0.05))


def test_no_bar_for_what_is_quick():
    assert on_a_terminal(BAR.format(patience=5.0)) == ""


def test_no_bar_off_a_terminal():
    ran = subprocess.run([sys.executable, "-c", BAR.format(patience=0.0)], capture_output=True, check=True)
    assert ran.stderr == ran.stdout == b""


def test_every_option_of_stitch_stands_in_one_section_of_its_help():
    from kinestitch.cli.stitch import SECTIONS, stitch

    named = [name for names in SECTIONS.values() for name in names]
    assert sorted(named) == sorted(option.name for option in stitch.params if option.param_type_name == "option")
