"""The number parser gives Python's own doubles, bit for bit, on every spelling that Python reads."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.files.decimals import bad_token, parse_decimals

AWKWARD = (
    "1 -1 +1 .5 -.5 5. 0 -0 -0.0 1e5 1E-3 -1.5e+03 12345678.12345678 99999999.99999999 123456789.1 "
    "0.016666666666666666 90071992.54740993 00000000.1 007 1e-400 4.9e-324 0.1 0.2 0.3 -.0083333"
)


def same_bits(text: bytes) -> None:
    values, starts = parse_decimals(text)
    expected = np.array([float(token) for token in text.split()])
    assert values.tobytes() == expected.tobytes()
    assert [text[start:].split()[0] for start in starts] == text.split()


@pytest.mark.parametrize("spelling", AWKWARD.split())
def test_one_number(spelling):
    same_bits(spelling.encode())


def test_all_spellings_in_one_text():
    same_bits("\r\n\t".join(AWKWARD.split()).encode())


floats = st.floats(allow_nan=False, allow_infinity=False)
spellings = st.one_of(
    floats.map(repr),
    st.floats(-1e6, 1e6).map(lambda x: f"{x:.6f}"),
    st.floats(-1e9, 1e9).map(lambda x: f"{x:.8f}"),
    floats.map(lambda x: f"{x:.3e}"),
    st.integers(-(10**18), 10**18).map(str),
)


@settings(deadline=None)
@given(st.lists(spellings, min_size=1, max_size=30), st.sampled_from([" ", "\n", "\t \r\n"]))
def test_any_numbers(tokens, gap):
    same_bits((gap + gap.join(tokens)).encode())


def test_no_numbers():
    values, starts = parse_decimals(b" \n\t ")
    assert len(values) == len(starts) == 0
    assert len(parse_decimals(b"")[0]) == 0


NO_NUMBERS = ["nan", "inf", "1_0", "1.2.3", "+-1", "-", ".", "+", "1-2", "1e", "e5", "0x10", "1,5", "1\x002", "--1"]


@pytest.mark.parametrize("token", NO_NUMBERS)
def test_no_number_is_refused_and_found(token):
    text = f"1 2 3\n4 {token} 6\n".encode()
    with pytest.raises(ValueError, match=r"decimal|convert"):
        parse_decimals(text)
    assert bad_token(text) == (1, 1, token)


def test_good_text_has_no_bad_token():
    assert bad_token(b"1 2\n3") is None
