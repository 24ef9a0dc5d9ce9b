"""The names of ``import kinestitch``: all there, all loaded late, and the example in its docstring is true."""

from __future__ import annotations

import doctest
import importlib

import pytest

import kinestitch


@pytest.mark.parametrize("name", kinestitch.__all__)
def test_every_name_is_the_thing_itself(name):
    room = importlib.import_module(f"kinestitch.{kinestitch._ROOMS[name]}")
    assert getattr(kinestitch, name) is getattr(room, name)
    assert getattr(kinestitch, name).__doc__


def test_names_are_listed():
    assert sorted(kinestitch._ROOMS) == kinestitch.__all__
    assert set(kinestitch.__all__) <= set(dir(kinestitch))
    assert 10 <= len(kinestitch.__all__) <= 16


def test_other_names_are_refused():
    with pytest.raises(AttributeError, match="no attribute 'sew'"):
        kinestitch.sew  # noqa: B018
    with pytest.raises(ImportError):
        exec("from kinestitch import sew")


def test_the_example_is_true():
    tried = doctest.testmod(kinestitch)
    assert tried.attempted >= 4
    assert tried.failed == 0
