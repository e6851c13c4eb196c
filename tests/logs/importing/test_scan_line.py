from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.importing.scan_line import BrokenLineError, exact_ns, finite


@given(st.decimals(-(10**10), 10**11, places=6))
def test_a_time_is_exact_to_its_last_digit(seconds: Decimal):
    assert exact_ns(str(seconds).encode(), float(seconds)) == int(seconds * 10**9)


@pytest.mark.parametrize("word", [b"nan", b"inf", b"-inf", b"1e999", b"0x1", b"1_0", b"1,5", b"x"])
def test_what_is_no_finite_number_is_refused(word: bytes):
    with pytest.raises(BrokenLineError, match="no number"):
        finite([b"1.5", word])
