"""Several policies in one loop: which of them decides, and how one takes over from another.

`SwappingController` has a `Controller` for each policy that may decide, and is one itself. A
`Swap` among the inputs names another policy by its hash. It takes over in front of a tick: at the
next standstill, or at once where the swap says so. If it fails (an exception, values that are not
finite, no such action), the former one decides that same tick, and from then on. So it does where
the watchdog ended a decision of the new one, and that had not answered since it took over, or since
the one that was ended before: one may be ended because the machine stood still.

What was seen stays, as both see with one eye. What a policy remembers, and the action that is being
done, are never carried over.

Pure: loading a policy decides nothing, so whoever does that fills `others` before it puts the swap.
The state says who serves; the same messages and the same policies give the same decisions.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, Serving, State
from reflexarc_runtime.decision import ASKED, Decision, Verdict
from reflexarc_runtime.guard import Guard
from reflexarc_runtime.messages.controls import ended_policy_of, swap_of
from reflexarc_runtime.messages.topics import OVERRUN, SWAP, Topic, topic_of
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import LoadedPolicy, Policy, RememberingPolicy
from reflexarc_runtime.rules import ControllerRules
from reflexarc_runtime.sensing.senses import Sense

SHOWN = 12
"""Characters of a hash that people are shown."""
_ROLLED_BACK = "rolled back to"
_STILL = 1e-3
"""A speed below that is none, m/s or rad/s."""


@dataclass(frozen=True, slots=True)
class SwappingController:
    """A controller whose policy may be swapped: see `Controller`."""

    first: Controller
    """Whose policy decides at the start."""
    others: Mapping[str, Controller]
    """By the hash of their policies; of the same eye, sense and rules."""

    @property
    def policy(self) -> Policy | RememberingPolicy:
        """Of the start."""
        return self.first.policy

    @property
    def policy_hash(self) -> str:
        """Of the start."""
        return self.first.policy_hash

    @property
    def contract(self) -> PolicyContract:
        """Of the start; eye, actions' names, rate and safe command are those of all others."""
        return self.first.contract

    @property
    def sense(self) -> Sense:
        """Of all of them."""
        return self.first.sense

    @property
    def rules(self) -> ControllerRules:
        """Of all of them."""
        return self.first.rules

    @property
    def guard(self) -> Guard | None:
        """Of the start."""
        return self.first.guard

    @property
    def ranges_topic(self) -> Topic | None:
        """See `Controller.ranges_topic`."""
        return self.first.ranges_topic

    def lack_of_ranges(self, state: State, now_ns: int) -> str:
        """See `Controller.lack_of_ranges`."""
        return self.first.lack_of_ranges(state, now_ns)

    def at(self, state: State) -> Controller:
        """Who decides in a state; the one of the start, where that policy is not known here."""
        return self._known(self._hash_of(state.serving)) or self.first

    def step(self, state: State, inputs: Inputs, now_ns: int) -> tuple[State, Decision]:
        """Decide one tick: see `Controller.step`."""
        state, words = self._heard(state, inputs, now_ns)
        following, decision = self.at(state).step(state, inputs, now_ns)
        if decision.verdict is Verdict.POLICY_FAULT and self._known(state.serving.former):
            words, state = self._back(state, decision.reason)
            following, decision = self.at(state).step(state, inputs, now_ns)
        if words:
            decision = replace(decision, reason="; ".join(filter(None, [words, decision.reason])))
        return self._noted(following, decision), decision

    def _heard(self, state: State, inputs: Inputs, now_ns: int) -> tuple[State, str]:
        """Who decides this tick, and what to say about it."""
        if not self.rules.knows_ended_decisions:
            return self._heard_formerly(state, inputs, now_ns)
        words = ""
        for message in inputs.messages:
            topic = topic_of(message.key)
            if topic is SWAP:
                state = self._offered(state, message)
            elif topic is OVERRUN:
                state, blamed = self._told_who_ended(state, ended_policy_of(message))
                words = blamed or words
        return self._taken_over(state), words

    def _told_who_ended(self, state: State, ended: str) -> tuple[State, str]:
        """After a decision was ended: it was that of the tick that the messages before were for."""
        if not ended:
            return state, ""
        state = self._taken_over(state)  # as it had at that tick, of which nothing else is left
        serving = state.serving
        if ended != self._hash_of(serving) or self._known(serving.former) is None:
            return state, ""
        if serving.answered:
            return replace(state, serving=replace(serving, answered=False)), ""
        words, state = self._back(state, "it gave no answer, its decision was ended")
        return state, words

    def _taken_over(self, state: State) -> State:
        """After a swap that is due now."""
        serving = state.serving
        if serving.pending and (serving.while_moving or _stands(state)):
            return handed_over(state, Serving(serving.pending, self._hash_of(serving)))
        return state

    def _heard_formerly(self, state: State, inputs: Inputs, now_ns: int) -> tuple[State, str]:
        """See `ControllerRules.knows_ended_decisions`: who decides, where a log does not say it."""
        words, topics = "", [topic_of(message.key) for message in inputs.messages]
        if OVERRUN in topics and self._known(state.serving.former):
            words, state = self._overran(state, inputs, now_ns)
        for topic, message in zip(topics, inputs.messages, strict=True):
            if topic is SWAP:
                state = self._offered(state, message)
        return self._taken_over(state), words

    def _overran(self, state: State, inputs: Inputs, now_ns: int) -> tuple[str, State]:
        """After a late tick: a policy that would be asked and has not answered yet hung."""
        if state.serving.answered:
            return "", replace(state, serving=replace(state.serving, answered=False))
        if self.at(state).would_ask(state, inputs, now_ns):
            return self._back(state, "it hung")
        return "", state

    def _offered(self, state: State, message: Message) -> State:
        """After a swap: one that nobody has loaded, or that serves already, changes nothing."""
        swap, serving = swap_of(message), state.serving
        if swap is None or self._known(swap.policy_hash) is None:
            return state
        if swap.policy_hash == self._hash_of(serving):
            return replace(state, serving=replace(serving, pending="", while_moving=False))
        offered = replace(serving, pending=swap.policy_hash, while_moving=swap.while_moving)
        return replace(state, serving=offered)

    def _back(self, state: State, why: str) -> tuple[str, State]:
        """The former policy decides again; what to say, and the state."""
        serving = state.serving
        failed, former = self._hash_of(serving)[:SHOWN], serving.former
        words = f"policy {failed} failed ({why}): {_ROLLED_BACK} {former[:SHOWN]}"
        pending, while_moving = serving.pending, serving.while_moving
        if pending == former and self.rules.calls_off_swap_to_former:
            pending, while_moving = "", False
        return words, handed_over(state, Serving(former, "", pending, while_moving))

    def _noted(self, following: State, decision: Decision) -> State:
        serving = following.serving
        if serving.former and not serving.answered and decision.verdict in ASKED:
            return replace(following, serving=replace(serving, answered=True))
        return following

    def _hash_of(self, serving: Serving) -> str:
        return serving.policy_hash or self.first.policy_hash

    def _known(self, policy_hash: str) -> Controller | None:
        if not policy_hash:
            return None
        if policy_hash == self.first.policy_hash:
            return self.first
        return self.others.get(policy_hash)


def controller_for(policy: LoadedPolicy, first: Controller) -> Controller:
    """The controller of another policy, with the sense, the rules and the guard of the first."""
    contract, guard = policy.contract, first.guard
    if guard is not None:
        guard = Guard.for_contract(guard.settings, contract)
    return replace(
        first, policy=policy, contract=contract, policy_hash=policy.policy_hash, guard=guard
    )


def handed_over(state: State, serving: Serving) -> State:
    """The state in which another policy decides: what the former remembered, and did, is gone."""
    return replace(state, serving=serving, memory=None, following=None, hold=None)


def says_rolled_back(reason: str) -> bool:
    """Whether the reason of a decision says that the former policy decides again, from here on."""
    return reason.startswith("policy ") and f" {_ROLLED_BACK} " in reason


AnyController: TypeAlias = Controller | SwappingController


def _stands(state: State) -> bool:
    """Whether the body was told to stand, and is believed to have come to that."""
    moving = state.moving
    rolls = moving is not None and any(abs(speed) > _STILL for speed in moving.twist)
    return not state.drove and not rolls
