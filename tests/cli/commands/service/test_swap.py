"""What `reflexarc swap` says of an answer."""

from reflexarc.commands.service.swap import _plain
from reflexarc_runtime import messages_pb2 as pb


def test_every_outcome_has_a_name_and_one_that_nobody_knows_is_no_exception():
    names = [_plain(pb.SwapAnswer(outcome=number))["outcome"] for number in (0, 1, 2, 3)]
    assert names == ["refused", "taken", "waiting", "rolled_back"]
    younger = pb.SwapAnswer.FromString(b"\x08\x63")  # field 1 = 99
    assert _plain(younger)["outcome"] == "unknown"
