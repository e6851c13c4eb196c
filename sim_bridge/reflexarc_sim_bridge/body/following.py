"""A body that lives on under another runtime: who holds it says what it shall see.

A body without a policy of its own is built for the contract of the runtime that it meets. When
another one gets its lease (`gate/lease.py`), that one is asked for its policy, and nobody else's
answer counts. A thread of its own asks and builds, as both may take seconds; the body's loop looks,
once a step, and never waits:

    is_open(holder) → whether the holder's contract is not known yet: the body stands meanwhile
    successor(holder) → the body that was built for the holder, once

Who holds the lease and answers nothing is obeyed by the eye that there is, and asked again.
"""

import threading
from collections.abc import Callable
from dataclasses import replace
from types import TracebackType
from typing import Self

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye_in_words import eye_in_words
from reflexarc_runtime.errors import ReflexarcError, first_line
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.gate.lease import NOBODY

AGAIN_S = 1.0
"""Time between two questions to a holder that does not answer."""
_PATIENCE_S = 10.0
"""How long the end waits for the thread; it may be compiling."""


class Following:
    """Builds a body for each new holder of its lease; a context manager around its thread.

    Args:
        ask: the contract of whoever has this identifier; None if it does not say. May block.
        build: a body of a contract, anywhere in its world.
        contract: what the body is built for now.
        holder: by whom.
        say: tells the user, in a line.
    """

    def __init__(
        self,
        ask: Callable[[bytes], PolicyContract | None],
        build: Callable[[PolicyContract], Body],
        contract: PolicyContract,
        holder: bytes,
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._ask, self._build, self._say = ask, build, say
        self._contract, self._holder = contract, holder
        # Both are for a holder beside the contract that the body had: should the loop have taken
        # another body meanwhile, they say nothing.
        self._settled = self._answered = holder, contract
        self._built: tuple[bytes, Body] | None = None
        self._changed, self._ended = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._serve, name="following", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._changed.set()
        self._thread.join(_PATIENCE_S)

    def is_open(self, holder: bytes) -> bool:
        """Whether the contract of the lease's holder is not known yet. Called once a step."""
        if holder == NOBODY:
            return False
        if holder != self._holder:
            self._holder = holder
            self._changed.set()
        return (holder, self._contract) != self._settled

    def successor(self, holder: bytes) -> Body | None:
        """The body that was built for the holder; the one who takes it uses it from now on."""
        built = self._built
        if built is None or built[0] != holder:
            return None
        self._built, self._contract = None, built[1].contract
        self._settled = self._answered = holder, self._contract
        return built[1]

    def _serve(self) -> None:
        while not self._ended.is_set():
            self._changed.wait(AGAIN_S)
            self._changed.clear()
            question = self._holder, self._contract
            if question != self._answered and not self._ended.is_set():
                self._serve_one(*question)

    def _serve_one(self, holder: bytes, present: PolicyContract) -> None:
        """Ask one holder and build its body. Whatever goes wrong, the body stays what it is."""
        try:
            contract = self._ask(holder)
            if contract is None:
                self._settled = holder, present  # and asked again
                return
            self._answered = holder, present
            if _alike(contract, present):
                self._settled = holder, present
                return
            self._built = holder, self._build(contract)
            self._say(f"built anew for runtime {holder.hex()[:8]}: {eye_in_words(contract.retina)}")
        except Exception as error:  # a stranger's contract must not end a drive
            self._settled = self._answered = holder, present
            words = str(error) if isinstance(error, ReflexarcError) else first_line(error)
            self._say(f"stays as it is under runtime {holder.hex()[:8]}: {words}")


def _alike(one: PolicyContract, other: PolicyContract) -> bool:
    """Whether a body of one contract is a body of the other one too."""
    return _for_a_body(one) == _for_a_body(other)


def _for_a_body(contract: PolicyContract) -> tuple[object, ...]:
    """What of a contract makes a body: all but how its policy remembers, waits and was made."""
    return (
        replace(contract.retina, frames=1),
        contract.actions,
        contract.safe_command,
        contract.max_input_age_s,
        contract.rate_hz,
    )
