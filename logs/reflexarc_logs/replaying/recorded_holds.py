"""What was being done at each tick of a log, and since when: from its ticks alone."""

from reflexarc_logs.columns.tick_runs import TickRun
from reflexarc_logs.replaying.runs.held_rows import HeldRows, held_rows
from reflexarc_runtime.choice import Hold
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import ASKED, Verdict
from reflexarc_runtime.messages_pb2 import Decision

ASKED_VALUES = frozenset(verdict.value for verdict in ASKED)
"""The verdicts at which the policy was asked, as a log holds them."""
_OK = Verdict.OK.value  # looked up once: an enum's value costs more than all else here


class RecordedHolds:
    """Follows the actions of a log.

    Args:
        contract: of the policy that drove.
        held: what is done when it begins, if that is known.
        index: of the tick that comes first.
    """

    def __init__(self, contract: PolicyContract, held: Hold | None = None, index: int = 0) -> None:
        self._contract = contract
        self._is_known = held is not None
        self._index = index - 1
        self.misses = False
        """Whether ticks are missing in front of the last one that was asked about."""
        self.held = held
        """What was done at the last tick; None if its verdict was not OK."""

    @classmethod
    def anew(cls, contract: PolicyContract, index: int) -> "RecordedHolds":
        """Of a policy that takes over in front of a tick: nothing is held then."""
        holds = cls(contract, None, index)
        holds._is_known = True
        return holds

    def are_known(self, decision: Decision) -> bool:
        """Whether it is known what was held before this tick.

        In a slice of a log, and where ticks are missing, it is not, until a tick is not OK, the
        action changes, or it has been done for longer than any hold.
        """
        self.misses = self._index + 1 < decision.index
        if decision.index != self._index + 1:
            self.held, self._is_known = None, False  # ticks are missing
        if self._is_known or not decision.index:
            self._is_known = True
            return True
        held = self.held
        if held is not None and decision.slot - held.since_slot >= self._contract.hold_slots:
            self._is_known = True
        return self._is_known

    def saw(self, decision: Decision) -> bool:
        """Take the next tick; whether a memory of the policy's went on at it."""
        action, self._index = decision.action, decision.index
        if decision.verdict != _OK or not 0 <= action < len(self._contract.actions):
            self.held, self._is_known = None, True
            return decision.verdict in ASKED_VALUES
        if self.held is None or action != self.held.action:
            self._is_known = self._is_known or self.held is not None
            self.held = Hold(action, decision.slot)
        return True

    def follow(self, run: TickRun) -> HeldRows | None:
        """Take a run of ticks; what was held before each, or None if it has to be asked of each."""
        actions = run.numbers("action")
        is_next = self._is_known and run.first == self._index + 1
        if not is_next or actions.min() < 0 or actions.max() >= len(self._contract.actions):
            return None
        rows, self.held = held_rows(self.held, actions, run.numbers("slot"))
        self._index += len(run)
        self.misses = False
        return rows
