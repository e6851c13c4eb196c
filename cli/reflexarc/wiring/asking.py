"""Asking the runtimes on the bus for their policies: anybody may answer, with anything.

Each answer is tried in a process of its own, once; what is refused is said once.
"""

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import ReflexarcError, UsageError

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus, PolicyAnswer
    from reflexarc_runtime.contract.bounds import Bounds
    from reflexarc_runtime.contract.contract import PolicyContract

ASK_S = 0.5
"""How long one question waits for its answers."""
_MOST_KNOWN = 64
"""Answers that are remembered; of more, those of before may be tried and told again."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """A contract that somebody wants a body to be built for."""

    sender: bytes
    """Who says so: the identifier of its commands."""
    contract: "PolicyContract"


@dataclass
class Asking:
    """Asks for policies, and remembers what came."""

    bus: "Bus"
    bounds: "Bounds | None"
    """What a contract may ask for at most."""
    say: Callable[[str], None]
    """Tells the user, in a line."""
    check: "Callable[[PolicyContract], object]" = lambda contract: None
    """Raises a `ReflexarcError` where nothing can be built for a contract."""
    has_heard: bool = False
    """Whether anybody has answered, whatever it was."""
    _known: "dict[bytes, PolicyContract | None]" = field(default_factory=dict)

    def anybody(self) -> Wanted | None:
        """The first contract of anybody that can be used; None if there is none now."""
        for answer in self.bus.policy_answers(ASK_S):
            contract = self._read(answer)
            if contract is not None:
                return Wanted(answer.sender, contract)
        return None

    def of(self, sender: bytes) -> "PolicyContract | None":
        """The contract of whoever has this identifier; None if it gives none that can be used.

        Anybody can say that it is the one: where two of that name differ, neither is believed.
        """
        answers = {a.data: a for a in self._answers_of(sender)}
        if len(answers) > 1:
            if sender not in self._known:
                self.say(f"two answer as runtime {sender.hex()[:8]}: neither is believed")
            return self._remember(sender, None)
        return next((self._read(answer) for answer in answers.values()), None)

    def _answers_of(self, sender: bytes) -> "Iterator[PolicyAnswer]":
        return (answer for answer in self.bus.policy_answers(ASK_S) if answer.sender == sender)

    def _read(self, answer: "PolicyAnswer") -> "PolicyContract | None":
        """The contract in an answer; None, and a line the first time, if it cannot be used."""
        from reflexarc_runtime.loop.trials.contract_trial import tried_contract

        self.has_heard = True
        digest = hashlib.sha256(answer.data).digest()
        if digest in self._known:
            return self._known[digest]
        try:
            contract = tried_contract(answer.data, self.bounds)
            self.check(contract)
        except UsageError:
            raise  # a flag of this command is wrong, whoever answers
        except ReflexarcError as error:
            who = answer.sender.hex()[:8]
            self.say(f"what {who} answers is no policy to build an eye for: {error}")
            return self._remember(digest, None)
        return self._remember(digest, contract)

    def _remember(
        self, digest: bytes, contract: "PolicyContract | None"
    ) -> "PolicyContract | None":
        while len(self._known) >= _MOST_KNOWN:
            del self._known[next(iter(self._known))]
        self._known[digest] = contract
        return contract
