"""What a policy said that only watched: asked again, and compared.

A shadow's message names its tick, and tells where its memory and its held action began anew; so
what it said follows from the ticks. What stands in front of the first beginning in a slice is not
compared where the policy remembers or holds.
"""

from collections import OrderedDict
from collections.abc import Iterator

import numpy as np

from reflexarc_logs.reading.reader import Log, decode
from reflexarc_logs.replaying.comparison import EqualityRules, Tally, find_flip
from reflexarc_logs.replaying.message_fields import Difference
from reflexarc_logs.replaying.report import Flip, LevelResult
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_runtime.messages.topics import SHADOW, TICK
from reflexarc_runtime.messages_pb2 import Decision, Shadow, Tick
from reflexarc_runtime.serving.shadowing import ShadowMind, ShadowTick

GIVEN = ("index", "policy_hash", "begins", "is_newer")
"""Which ticks it was given, and by whom."""
MOST_AHEAD = 256
"""Asked ticks that are kept for what a shadow says of them: it may be a few behind."""
_FIELDS = 5


def replay_shadows(
    log: Log, served: ServedPolicies, rules: EqualityRules, robot: str = ""
) -> tuple[LevelResult, list[str]]:
    """Ask the policies again that watched a log's loop.

    Args:
        log: the log.
        served: its policies.
        rules: what counts as equal.
        robot: see `LevelResult.robot`.

    Returns:
        The result, and what its reader should know.

    Raises:
        LogError: the log cannot be read.
        PolicyError, ContractError: a policy that watched is not intact.
    """
    asking = _Asking(served, Tally("shadow", rules, robot=robot))
    tick_topic = log.topic(TICK.name)
    for record in log.records(tick_topic, log.topic(SHADOW.name)):
        if record.topic == tick_topic:
            asking.keep(decode(log, record, Tick).decision)
        else:
            asking.compare(decode(log, record, Shadow))
    return asking.tally.result(given=GIVEN), list(asking.notes())


class _Asking:
    """The shadows of a log, on their way through it."""

    def __init__(self, served: ServedPolicies, tally: Tally) -> None:
        self.tally = tally
        self._served = served
        self._asked: OrderedDict[int, Decision] = OrderedDict()
        self._minds: dict[str, ShadowMind | None] = {}
        self._begun: set[str] = set()
        self._without_policy = self._without_tick = self._before_it_began = 0

    def keep(self, decision: Decision) -> None:
        """Keep a tick at which the policy was asked."""
        if decision.retina:
            self._asked[decision.index] = decision
            if len(self._asked) > MOST_AHEAD:
                self._asked.popitem(last=False)

    def compare(self, said: Shadow) -> None:
        """Ask again about what a shadow said."""
        self.tally.ticks += 1
        mind, decision = self._mind(said.policy_hash), self._asked.get(said.index)
        if mind is None:
            self._without_policy += 1
        elif decision is None:
            self._without_tick += 1
            self._begun.discard(said.policy_hash)
        elif said.begins or said.policy_hash in self._begun or not self._depends(said):
            self._begun.add(said.policy_hash)
            again = mind.decide(_tick_of(said, decision))
            self.tally.add(said.index, _FIELDS, *_compared(said, again, self.tally.rules))
        else:
            self._before_it_began += 1

    def notes(self) -> Iterator[str]:
        """What was not compared."""
        if self._without_policy:
            yield f"{self._without_policy} words of a shadow whose policy is not in the log"
        if self._without_tick:
            yield f"{self._without_tick} words of a shadow on ticks that are not in the log"
        if self._before_it_began:
            yield f"{self._before_it_began} words of a shadow whose memory began before the log"

    def _mind(self, identity: str) -> ShadowMind | None:
        if identity not in self._minds:
            policy = self._served.named(identity) if identity else None
            self._minds[identity] = None if policy is None else ShadowMind(policy)
        return self._minds[identity]

    def _depends(self, said: Shadow) -> bool:
        """Whether what it says hangs on what it said before."""
        policy = self._served.named(said.policy_hash)
        return policy is None or policy.contract.keeps_actions or policy.contract.state.size > 0


def _tick_of(said: Shadow, decision: Decision) -> ShadowTick:
    return ShadowTick(
        said.index, decision.slot, decision.retina, decision.winner, said.begins, said.is_newer
    )


def _compared(
    said: Shadow, again: Shadow, rules: EqualityRules
) -> tuple[list[Difference], Flip | None]:
    """How its words differ, and whether another action won by rounding."""
    differences = list(_value_differences(said, again))
    flip = None
    if said.winner != again.winner:
        flip = find_flip(said.index, said.q_values, said.winner, again.winner, rules.tolerance)
    names = ["winner", "action", "drove", "fault"]
    for name in names if rules.exact else names[:-1]:
        was, now = getattr(said, name), getattr(again, name)
        if was != now:
            differences.append(Difference(name, str(was), str(now)))
    return differences, flip


def _value_differences(said: Shadow, again: Shadow) -> Iterator[Difference]:
    if len(said.q_values) != len(again.q_values):
        yield Difference("q_values", str(len(said.q_values)), str(len(again.q_values)))
        return
    for place, (old, new) in enumerate(zip(said.q_values, again.q_values, strict=True)):
        if np.float32(old).tobytes() != np.float32(new).tobytes():
            yield Difference(f"q_values[{place}]", repr(old), repr(new))
