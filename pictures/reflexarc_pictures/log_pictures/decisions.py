"""What a log says about its decisions."""

from collections.abc import Sequence

import numpy as np

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.log_pictures.decision_strips import Decisions, Floats
from reflexarc_runtime.contract import PolicyContract, Shading
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import load_policy

BRIGHT = {Shading.NEARNESS: "near", Shading.COLOUR: "brightly coloured"}


def decisions_of(log: Log) -> Decisions:
    """Every tick of a log, in order.

    Raises:
        LogError: there is none, or the log names no policy.
    """
    made = [tick.decision for tick in log.ticks()]
    if not made or log.policy is None:
        raise LogError(
            f"{log.path}: expected the ticks and the policy of `reflexarc run --record`, found "
            f"{'no ticks' if not made else 'no policy'}; play it into a runtime that records"
        )
    contract = load_policy(log.policy, verify=False).contract
    return Decisions(
        time_s=np.array([decision.now_ns - made[0].now_ns for decision in made]) * 1e-9,
        retinas=_retinas(made, contract),
        q_values=_q_values(made, contract),
        actions=np.array([decision.action for decision in made], np.int64),
        action_names=tuple(action.name for action in contract.actions),
        bright=BRIGHT[contract.retina.shading],
    )


def _retinas(made: Sequence[Decision], contract: PolicyContract) -> Floats:
    """The newest retina of each stack, of each ray its brightest channel: (ticks, rays)."""
    eye = contract.retina
    retinas = np.full((len(made), eye.eyes * eye.rays), np.nan)
    for row, decision in zip(retinas, made, strict=True):
        if len(decision.retina) == eye.frames * eye.size:
            newest = np.frombuffer(decision.retina, np.uint8)[-eye.size :]
            row[:] = newest.reshape(-1, eye.channels).max(axis=1)
    return retinas


def _q_values(made: Sequence[Decision], contract: PolicyContract) -> Floats:
    actions = len(contract.actions)
    values = np.full((len(made), actions), np.nan)
    for row, decision in zip(values, made, strict=True):
        if len(decision.q_values) == actions:
            row[:] = decision.q_values
    return values
