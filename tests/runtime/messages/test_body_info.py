import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body, encode_body

SPEEDS = st.floats(0.0, 1e300)
LIMIT = SPEEDS | st.just(math.inf)
GROWTH = st.floats(1e-3, 1e300) | st.just(math.inf)
VALIDITY = st.integers(1, 10**9).map(lambda ms: ms / 1e3) | st.just(math.inf)
LIMITS = st.builds(BodyLimits, LIMIT, LIMIT, LIMIT, GROWTH, VALIDITY)
COUNTS = st.integers(0, 2**64 - 1)
INFOS = st.builds(BodyInfo, st.text(), st.text(), COUNTS, COUNTS, SPEEDS, st.none() | LIMITS)


@given(INFOS)
def test_what_a_body_says_survives_the_wire(info: BodyInfo):
    assert decode_body(encode_body(info)) == info


def test_a_body_that_cannot_move_so_at_all_is_not_one_without_limits():
    still = BodyInfo(limits=BodyLimits(0.0, 0.0, 0.0))
    assert decode_body(encode_body(still)) == still != BodyInfo()


@pytest.mark.parametrize("number", [-1.0, math.nan, math.inf])
def test_numbers_that_are_no_times_and_speeds_are_none(number: float):
    assert decode_body(pb.Body(step_s=number).SerializeToString()) is None
    # An infinite limit is none.
    limits = pb.BodyLimits(angular_radps=number if number < math.inf else math.nan)
    assert decode_body(pb.Body(limits=limits).SerializeToString()) is None


@given(st.binary(max_size=60))
def test_any_bytes_are_a_body_or_none(payload: bytes):
    assert isinstance(decode_body(payload), BodyInfo | None)
