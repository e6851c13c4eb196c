import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Command, Verdict
from reflexarc_runtime.messages.body_info import BodyInfo, BodyLimits, decode_body, encode_body

SPEEDS = st.floats(0.0, 1e300)
LIMITS = st.builds(BodyLimits, SPEEDS, SPEEDS, SPEEDS)
COUNTS = st.integers(0, 2**64 - 1)
INFOS = st.builds(BodyInfo, st.text(), st.text(), COUNTS, COUNTS, SPEEDS, st.none() | LIMITS)


def command(linear_mps: float, lateral_mps: float, angular_radps: float) -> Command:
    return Command(0, 0, Verdict.OK, linear_mps, lateral_mps, angular_radps)


@given(INFOS)
def test_what_a_body_says_survives_the_wire(info: BodyInfo):
    assert decode_body(encode_body(info)) == info


def test_a_body_that_cannot_move_so_at_all_is_not_one_without_limits():
    still = BodyInfo(limits=BodyLimits(0.0, 0.0, 0.0))
    assert decode_body(encode_body(still)) == still != BodyInfo()


@pytest.mark.parametrize("number", [-1.0, math.nan, math.inf])
def test_numbers_that_are_no_times_and_speeds_are_none(number: float):
    limits = pb.BodyLimits(angular_radps=number)
    assert decode_body(pb.Body(step_s=number).SerializeToString()) is None
    assert decode_body(pb.Body(limits=limits).SerializeToString()) is None


@given(st.binary(max_size=60))
def test_any_bytes_are_a_body_or_none(payload: bytes):
    assert isinstance(decode_body(payload), BodyInfo | None)


def test_limits_allow_what_is_within_them_in_every_direction():
    limits = BodyLimits(1.0, 0.5, 0.0)
    assert limits.allow(command(-1.0, 0.5, 0.0))
    for beyond in ((1.1, 0.0, 0.0), (0.0, -0.6, 0.0), (0.0, 0.0, 0.1), (math.nan, 0.0, 0.0)):
        assert not limits.allow(command(*beyond))
