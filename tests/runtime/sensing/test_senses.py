import math

import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.sensing.senses import sense_for
from support.policies import ScriptedPolicy

CONTRACT = PolicyContract(retina=RetinaSpec(rays=4))
STAMP = pack_stamp(Stamp(0, 0))


def decided(kind: str, payload: bytes, attachment: bytes = STAMP) -> Decision:
    """What the controller makes of one message."""
    sense = sense_for(kind, CONTRACT.retina)
    key, encoding = sense.topic.key("robot0"), protobuf_encoding(sense.topic.schema)
    controller = Controller(ScriptedPolicy(), CONTRACT, sense)
    message = Message(key, payload, encoding, attachment, 0)
    return controller.step(State(), Inputs((message,), 0), 0)[1]


def scan(start_rad: float, end_rad: float, ranges: list[float]) -> bytes:
    return LaserScan(start_angle=start_rad, end_angle=end_rad, ranges=ranges).SerializeToString()


@pytest.mark.parametrize(
    ("start_rad", "end_rad"),
    [(0.0, 5e-324), (-1e308, 1e308), (0.0, 1e-12), (1e300, 2e300), (0.0, -1.0), (0.0, math.nan)],
)
def test_a_scan_of_absurd_angles_is_invalid_and_not_the_end_of_the_loop(
    start_rad: float, end_rad: float
):
    decision = decided("scan", scan(start_rad, end_rad, [1.0, 1.0, 1.0]))
    assert decision.verdict is Verdict.INVALID_INPUT
    assert decision.command.is_safe


@given(st.floats(), st.floats(), st.lists(st.floats(), max_size=12))
@settings(deadline=None)
def test_no_scan_whatsoever_raises(start_rad: float, end_rad: float, ranges: list[float]):
    decision = decided("scan", scan(start_rad, end_rad, ranges))
    assert decision.verdict in (Verdict.INVALID_INPUT, Verdict.RECOVERING)


def test_a_sender_s_own_words_are_not_repeated_at_length_in_every_tick():
    image = RawImage(width=4, height=1, encoding="x" * 1_000_000, data=bytes(4))
    decision = decided("retina", image.SerializeToString())
    assert decision.verdict is Verdict.INVALID_INPUT
    assert 0 < len(decision.reason) < 300


def test_an_attachment_beyond_all_sizes_is_refused_without_its_exact_size():
    reasons = {decided("retina", b"", bytes(size)).reason for size in (65_536, 100_000, 1 << 20)}
    assert len(reasons) == 1  # what a log keeps of it gives the same reason
    assert "32" in decided("retina", b"", bytes(32)).reason
