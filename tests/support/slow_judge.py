"""A candidate judged the slow way: tick by tick, with onnxruntime's graph and nothing of ours."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime
from mcap.reader import NonSeekingReader

from reflexarc_runtime.messages_pb2 import Decision, Tick

OPPOSITE = {(1, 2), (2, 1)}
"""Of the actions stay, left, right."""


@dataclass(frozen=True)
class SlowFlip:
    tick: int
    time_s: float
    recorded: int
    candidate: int
    margin: float
    candidate_q_values: tuple[float, ...]

    @property
    def is_reversal(self) -> bool:
        return (self.recorded, self.candidate) in OPPOSITE


def decisions(log: Path) -> list[Decision]:
    with log.open("rb") as file:
        return [
            Tick.FromString(message.data).decision
            for schema, _, message in NonSeekingReader(file).iter_messages(log_time_order=False)
            if schema.name == "reflexarc.Tick"
        ]


def slow_flips(log: Path, policy: bytes, rays: int = 16) -> list[SlowFlip]:
    """All flips of a policy that sees one grey retina and remembers nothing."""
    session = onnxruntime.InferenceSession(policy)
    ticks, flips = decisions(log), []
    for one in ticks:
        if not one.q_values:
            continue
        stack = np.frombuffer(one.retina, np.uint8).reshape(1, 1, 1, rays, 1)
        q_values, action = session.run(None, {"retina": stack})[:2]
        now = int(action[0])
        if now != one.winner:
            time_s = (one.now_ns - ticks[0].now_ns) / 1e9
            margin = one.q_values[one.winner] - one.q_values[now]
            values = tuple(q_values[0].tolist())
            flips.append(SlowFlip(one.index, time_s, one.winner, now, margin, values))
    return flips
