"""The controller: a pure function from the messages that arrived to a decision.

    step(state, inputs, now_ns) → (state, decision)

No clock, bus, file or randomness. It is given raw bytes and decodes them itself, so that bad
input replays too. Unless the input is good and fresh and the action values are finite, the decision
is the safe command, with a verdict that says why; there is never an exception.
"""

from dataclasses import dataclass, replace

import numpy as np

from reflexarc_runtime.arrays import Retina, RetinaStack
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import (
    SAFE_ACTION,
    Decision,
    Input,
    Verdict,
    drive_command,
    safe_command,
)
from reflexarc_runtime.messages.wire import Message, Stamp, UndecodableError, UnfitError
from reflexarc_runtime.policy.policy import Policy
from reflexarc_runtime.sensing.senses import Sense, Sensed

RECOVERY_INPUTS = 3
"""Consecutive good inputs before the policy may drive, at the start and after every fault."""


@dataclass(frozen=True, slots=True)
class Inputs:
    """What arrived for a tick."""

    messages: tuple[Message, ...]
    """All that arrived since the last tick, oldest first."""
    slot: int
    """Number of the deadline that this tick belongs to."""
    stop: bool = False
    """The runtime has been asked to end."""


@dataclass(frozen=True, slots=True)
class State:
    """What the controller remembers from one tick to the next."""

    index: int = 0
    streak: int = 0
    """Good inputs in a row."""
    newest: Sensed | None = None
    frames: tuple[Retina, ...] = ()
    """The last accepted retinas, oldest first."""
    fault: str = ""
    """Why the newest message cannot be used; empty if it can."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the policy computed, or why it was not asked."""

    verdict: Verdict
    reason: str = ""
    stack: bytes = b""
    q_values: tuple[float, ...] = ()
    action: int = SAFE_ACTION


@dataclass(frozen=True, slots=True)
class Controller:
    """A policy, its contract, and the sense that turns messages into retinas."""

    policy: Policy
    contract: PolicyContract
    sense: Sense
    policy_hash: str = ""

    def step(self, state: State, inputs: Inputs, now_ns: int) -> tuple[State, Decision]:
        """Decide one tick.

        Args:
            state: what the last step returned; `State()` at the start.
            inputs: the messages that arrived since, and the slot.
            now_ns: the runtime's monotonic clock, read once for this tick.
        """
        for message in inputs.messages:
            state = self._accept(state, message)
        verdict, reason = self._judge(state, inputs.stop, now_ns)
        if verdict is Verdict.STALE_INPUT:
            state = replace(state, streak=0)
        outcome = self._ask(state) if verdict is Verdict.OK else Outcome(verdict, reason)
        decision = self._conclude(state, inputs, now_ns, outcome)
        return replace(state, index=state.index + 1), decision

    def _accept(self, state: State, message: Message) -> State:
        try:
            sensed = self.sense.decode(message)
        except (UndecodableError, UnfitError) as error:
            return replace(state, streak=0, fault=str(error))
        if state.streak and not _is_newer(sensed.stamp, state.newest):
            return state
        return replace(
            state,
            streak=state.streak + 1,
            newest=sensed,
            frames=self._push(state.frames, sensed.retina),
            fault="",
        )

    def _push(self, frames: tuple[Retina, ...], retina: Retina) -> tuple[Retina, ...]:
        depth = self.contract.retina.frames
        return (*(frames or (retina,) * depth), retina)[-depth:]

    def _judge(self, state: State, stop: bool, now_ns: int) -> tuple[Verdict, str]:
        if stop:
            return Verdict.STOPPED, "asked to stop"
        if state.fault:
            return Verdict.INVALID_INPUT, state.fault
        if state.newest is None:
            return Verdict.NO_INPUT, "nothing has arrived"
        age_ns, limit_ns = now_ns - state.newest.received_ns, self.contract.max_input_age_ns
        if age_ns > limit_ns:
            return Verdict.STALE_INPUT, f"older than {limit_ns / 1e6:g} ms"
        if state.streak < RECOVERY_INPUTS:
            return Verdict.RECOVERING, f"{state.streak} of {RECOVERY_INPUTS} good inputs in a row"
        return Verdict.OK, ""

    def _ask(self, state: State) -> Outcome:
        stack: RetinaStack = np.stack(state.frames)
        try:
            q_values, actions = self.policy.decide(stack[np.newaxis])
            values, action = tuple(q_values[0].tolist()), int(actions[0])
        except Exception as error:  # whatever a policy does, the body gets its safe command
            return Outcome(Verdict.POLICY_FAULT, type(error).__name__, stack.tobytes())
        if not np.isfinite(q_values).all() or not 0 <= action < len(self.contract.actions):
            return Outcome(
                Verdict.POLICY_FAULT,
                "values not finite, or no such action",
                stack.tobytes(),
                values,
            )
        return Outcome(Verdict.OK, "", stack.tobytes(), values, action)

    def _conclude(self, state: State, inputs: Inputs, now_ns: int, outcome: Outcome) -> Decision:
        used = _input_of(state.newest, now_ns)
        if outcome.verdict is Verdict.OK and used is not None:
            motion = self.contract.actions[outcome.action]
            valid_for_ns = self.contract.max_input_age_ns
            command = drive_command(state.index, outcome.action, motion, used, valid_for_ns)
        else:
            command = safe_command(state.index, outcome.verdict, self.contract.safe_command)
        return Decision(
            index=state.index,
            slot=inputs.slot,
            now_ns=now_ns,
            inputs=len(inputs.messages),
            input=used,
            retina=outcome.stack,
            q_values=outcome.q_values,
            action=outcome.action,
            verdict=outcome.verdict,
            reason=outcome.reason,
            command=command,
            policy_hash=self.policy_hash,
        )


def _is_newer(stamp: Stamp, newest: Sensed | None) -> bool:
    """Whether a message is newer than the last accepted one.

    A repeated or reordered message has neither a larger number nor a later time. One of the two is
    enough: a sender that restarts begins its numbers again, and a clock may step back. After a
    fault this is not asked: any good message is accepted.
    """
    if newest is None:
        return True
    return stamp.sequence > newest.stamp.sequence or stamp.time_ns > newest.stamp.time_ns


def _input_of(newest: Sensed | None, now_ns: int) -> Input | None:
    if newest is None:
        return None
    stamp, received_ns = newest.stamp, newest.received_ns
    return Input(stamp.sequence, stamp.time_ns, received_ns, now_ns - received_ns)
