"""Undo and redo, and drags that are one step."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.edit.history import History, commit, preview, redo, undo
from kinestitch.errors import ParameterError

commands = st.lists(st.tuples(st.sampled_from(["commit", "preview", "undo", "redo"]), st.integers(0, 3)), max_size=40)


@given(commands)
def test_equals_a_list_with_a_cursor(script):
    history, line, cursor, held = History(0), [0], 0, None
    for command, value in script:
        if command == "commit":
            history, held = commit(history, value), None
            if value != line[cursor]:
                line, cursor = [*line[: cursor + 1], value], cursor + 1
        elif command == "preview":
            history, held = preview(history, value), value
        elif command == "undo":
            history = undo(history)
            cursor, held = (cursor if held is not None else max(cursor - 1, 0)), None
        else:
            history, held = redo(history), None
            cursor = min(cursor + 1, len(line) - 1)
        assert history.value == (line[cursor] if held is None else held)
        assert [*history.past, history.present, *history.future] == line
    assert hash(history) == hash(history)


def test_a_drag_is_one_step():
    history = commit(History("walk"), "walk kick")
    dragged = history
    for frame in range(100):
        dragged = preview(dragged, f"walk kick {frame}")
    assert dragged.value == "walk kick 99"
    assert dragged.past == history.past
    done = commit(dragged, dragged.value)
    assert undo(done).value == "walk kick"
    assert redo(undo(done)) == done
    assert undo(dragged) == history


def test_a_drag_back_to_the_start_is_no_step_and_keeps_the_future():
    history = undo(commit(History("a"), "b"))
    assert commit(preview(history, "c"), "a") == history


def test_limit():
    history = History(0, limit=3)
    for value in range(1, 10):
        history = commit(history, value)
    assert history.past == (6, 7, 8)
    with pytest.raises(ParameterError, match="at least 1"):
        History(0, limit=0)
    with pytest.raises(ParameterError, match="at most one"):
        History(0, held=(1, 2))
