"""What was being done at each tick of a log, and since when: from its ticks alone."""

from reflexarc_runtime.choice import Hold
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import ASKED, Verdict
from reflexarc_runtime.messages_pb2 import Decision

_OK = Verdict.OK.value  # looked up once: an enum's value costs more than all else here
_ASKED = frozenset(verdict.value for verdict in ASKED)


class RecordedHolds:
    """Follows the actions of a log."""

    def __init__(self, contract: PolicyContract) -> None:
        self._contract = contract
        self._is_known = False
        self.held: Hold | None = None
        """What was done at the last tick; None if its verdict was not OK."""

    def are_known(self, decision: Decision) -> bool:
        """Whether it is known what was held before this tick.

        In a slice of a log it is not, until a tick is not OK, the action changes, or it has been
        done for longer than any hold.
        """
        if self._is_known or not decision.index:
            self._is_known = True
            return True
        held = self.held
        if held is not None and decision.slot - held.since_slot >= self._contract.hold_slots:
            self._is_known = True
        return self._is_known

    def saw(self, decision: Decision) -> bool:
        """Take the next tick; whether a memory of the policy's went on at it."""
        if decision.verdict != _OK:
            self.held, self._is_known = None, True
            return decision.verdict in _ASKED
        action = decision.action
        if self.held is None or action != self.held.action:
            self._is_known = self._is_known or self.held is not None
            self.held = Hold(action, decision.slot)
        return True
