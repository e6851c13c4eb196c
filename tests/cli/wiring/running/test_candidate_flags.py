"""The policy that watches is the one that was accepted, whatever lies at its path later."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from reflexarc.wiring.running.candidate_flags import CandidateFlags, others_of
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Decision, Input, Verdict, safe_command
from reflexarc_runtime.loop.outlets import NoOutlet
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import load_policy
from support.policies import SMALL, exported

BUS: Any = SimpleNamespace(publisher=lambda topic: NoOutlet(), robot="robot0", sender=b"s" * 16)
PIXELS = np.arange(SMALL.retina.size, dtype=np.uint8)


def said_of(flags: CandidateFlags, accepted: bytes | None, later: bytes) -> tuple[pb.Shadow, bytes]:
    """What it says of a tick where its file is another one meanwhile, and what a log holds."""
    said: list[Message] = []
    watcher = flags.watcher(SMALL, "numpy", accepted)
    assert watcher is not None
    assert flags.shadow is not None
    flags.shadow.write_bytes(later)
    used = Input(0, 0, 0, 0)
    tick = Decision(
        0,
        0,
        0,
        1,
        used,
        PIXELS.tobytes(),
        (0.0,),
        0,
        0,
        Verdict.OK,
        "",
        safe_command(0, Verdict.OK, SMALL.safe_command),
        "old",
    )
    with watcher.shadow(BUS, said.append, lockstep=True) as shadow:
        shadow.saw(tick)
    (held,) = others_of(watcher).items()
    assert held[0] == watcher.policy_hash == policy_hash(held[1])
    return pb.Shadow.FromString(said[0].payload), held[1]


def expected(policy: bytes) -> list[float]:
    stack = PIXELS.reshape(1, *SMALL.retina.stack_shape)
    values: list[float] = load_policy(policy).decide(stack)[0][0].tolist()
    return values


def test_a_file_that_is_replaced_after_it_was_tried_watches_nothing(tmp_path: Path):
    first, other = exported(SMALL, seed=3), exported(SMALL, seed=4)
    path = tmp_path / "shadow.onnx"
    path.write_bytes(first)
    said, held = said_of(CandidateFlags(shadow=path), None, other)
    assert (said.policy_hash, list(said.q_values)) == (policy_hash(first), expected(first))
    assert held == first


def test_a_file_that_is_replaced_after_it_was_accepted_is_not_read_again(tmp_path: Path):
    """It holds nothing that could be parsed."""
    accepted, path = exported(SMALL, seed=3), tmp_path / "shadow.onnx"
    path.write_bytes(b"none")
    said, held = said_of(CandidateFlags(shadow=path), accepted, b"none")
    assert (list(said.q_values), held) == (expected(accepted), accepted)
