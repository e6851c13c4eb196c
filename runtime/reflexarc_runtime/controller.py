"""The controller: a pure function from the messages that arrived to a decision.

    step(state, inputs, now_ns) → (state, decision)

No clock, bus, file or randomness. It is given raw bytes and decodes them itself, so that bad
input replays too. Unless the input is good and fresh and the action values are finite, the decision
is the safe command, with a verdict that says why; there is never an exception. A guard, where there
is one, lets only pass what is free.
"""

import math
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from reflexarc_runtime.arrays import Memories, QValues, Retina, RetinaStack
from reflexarc_runtime.backlog import NO_LAG, Lag, backlog_in_words
from reflexarc_runtime.beams import Beams
from reflexarc_runtime.choice import Hold, choose
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller_state import BoundBody, Inputs, State, bound_after
from reflexarc_runtime.decision import (
    ASKED,
    NO_WINNER,
    SAFE_ACTION,
    Decision,
    Input,
    Verdict,
    drive_command,
    safe_command,
)
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.guard import Guard
from reflexarc_runtime.inertia import STILL, Moving
from reflexarc_runtime.messages.controls import is_reset, lateness_of, stop_reason
from reflexarc_runtime.messages.topics import (
    OVERRUN,
    RESET,
    SENSORS,
    STOP,
    SWAP,
    Topic,
    topic_of,
)
from reflexarc_runtime.messages.wire import Message, Stamp, UndecodableError, UnfitError
from reflexarc_runtime.policy.policy import Policy, RememberingPolicy
from reflexarc_runtime.ranging import beams_of, heard, lack_of
from reflexarc_runtime.rules import CURRENT_RULES, ControllerRules
from reflexarc_runtime.sensing.senses import DEFAULT, Sense, Sensed
from reflexarc_runtime.sensing.stillness import MOVING, Still
from reflexarc_runtime.sweep import Speeds

_ENDS_STREAKS = (Verdict.STALE_INPUT, Verdict.INVALID_INPUT)
"""Verdicts after which good inputs must come in a row again."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the policy computed, or why it was not asked."""

    verdict: Verdict
    reason: str = ""
    stack: bytes = b""
    memory: tuple[float, ...] = ()
    q_values: tuple[float, ...] = ()
    winner: int = NO_WINNER
    hold: Hold | None = None
    following: Memories | None = None
    action: int = SAFE_ACTION
    """What is done."""
    share: float = 1.0
    """How much of its speed."""


@dataclass(frozen=True, slots=True)
class Controller:
    """A policy, its contract, and the sense that turns messages into retinas."""

    policy: Policy | RememberingPolicy
    """With a memory if the contract says that it has one."""
    contract: PolicyContract
    sense: Sense
    policy_hash: str = ""
    rules: ControllerRules = CURRENT_RULES
    guard: Guard | None = None
    """Lets only pass what is free; None: whatever the policy says is done."""

    def step(self, state: State, inputs: Inputs, now_ns: int) -> tuple[State, Decision]:
        """Decide one tick.

        Args:
            state: what the last step returned; `State()` at the start.
            inputs: the messages that arrived since, and the slot.
            now_ns: the runtime's monotonic clock, read once for this tick.
        """
        for message in inputs.messages:
            state = self._receive(state, message)
        verdict, reason = self._judge(state, inputs.stop, now_ns)
        is_good = verdict is Verdict.OK
        outcome = self._ask(state, inputs.slot) if is_good else Outcome(verdict, reason)
        if self.guard is not None and outcome.hold is not None:
            outcome = self._guarded(self.guard, outcome, outcome.hold, state, now_ns)
        decision = self._conclude(state, inputs, now_ns, outcome)
        return self._remember(state, outcome, decision), decision

    def at(self, state: State) -> "Controller":
        """Who decides in a state: this one, in all of them."""
        return self

    def would_ask(self, state: State, inputs: Inputs, now_ns: int) -> bool:
        """Whether the policy would be asked at a tick, if no tick had been late before it."""
        for message in inputs.messages:
            if topic_of(message.key) is not OVERRUN:
                state = self._receive(state, message)
        return self._judge(state, inputs.stop, now_ns)[0] is Verdict.OK

    def _moving(self, state: State, now_ns: int) -> Speeds | None:
        """How the body is believed to move; None where nobody asks. At first it stands."""
        braking = None if self.guard is None else self.guard.settings.follows_mps2
        if braking is None:
            return None
        if state.moving is None:
            return STILL
        return state.moving.later(now_ns, self.contract.max_input_age_ns, braking)

    def _told(self, state: State, decision: Decision) -> Moving | None:
        """How it is believed to move, and what it is told now."""
        twist, command = self._moving(state, decision.now_ns), decision.command
        if twist is None:
            return None
        commanded = command.linear_mps, command.lateral_mps, command.angular_radps
        return Moving(twist, commanded, decision.now_ns)

    def _receive(self, state: State, message: Message) -> State:
        topic = topic_of(message.key)
        if topic is STOP:
            return replace(state, stopped=stop_reason(message))
        if topic is RESET:
            if not is_reset(message):
                return state
            return replace(state, streak=0, stopped="", still=MOVING)
        if topic is OVERRUN:
            return replace(state, streak=0, overrun=lateness_of(message))
        if topic is SWAP:
            return state  # `SwappingController` has heard it
        if topic is not None and topic is self.ranges_topic and self.guard is not None:
            oldest_ns = self.guard.settings.ranges_oldest_ns
            settings = self.sense.settings or DEFAULT
            ages = self.rules.ages_backlogs
            return replace(state, ranges=heard(state.ranges, message, oldest_ns, settings, ages))
        return self._accept(state, message)

    @property
    def ranges_topic(self) -> Topic | None:
        """From where the guard has its ranges, if not from what the policy sees."""
        return None if self.guard is None else SENSORS.get(self.guard.settings.ranges)

    def lack_of_ranges(self, state: State, now_ns: int) -> str:
        """Why the guard has no ranges of a topic of their own, in words; empty if it has."""
        if self.guard is None or self.ranges_topic is None:
            return ""
        return lack_of(state.ranges, now_ns, self.guard.settings.ranges_oldest_ns)

    def _accept(self, state: State, message: Message) -> State:
        try:
            sensed = self.sense.decode(message)
        except (UndecodableError, UnfitError) as error:
            return replace(state, streak=0, fault=str(error))
        source = state.source
        if self.rules.one_source:
            source = self._source(state.source, sensed)
            if source.sender != sensed.stamp.sender:
                return replace(state, streak=0, source=source)
            if state.source is not None and state.source.sender != source.sender:
                state = replace(state, streak=0, backlog=NO_LAG)
        if state.streak and not _is_newer(sensed.stamp, state.newest):
            return state if source is state.source else replace(state, source=source)
        return State(  # every field by name: `replace` takes three times as long
            index=state.index,
            streak=state.streak + 1,
            newest=sensed,
            frames=self._push(state.frames, sensed.retina),
            fault="",
            memory=state.following,
            following=state.following,
            hold=state.hold,
            stopped=state.stopped,
            source=source,
            overrun=state.overrun,
            moving=state.moving,
            ranges=state.ranges,
            backlog=self._aged(state, sensed) if self.rules.ages_backlogs else NO_LAG,
            still=state.still.seen(sensed.picture) if sensed.picture else MOVING,
            serving=state.serving,
            drove=state.drove,
        )

    def _aged(self, state: State, sensed: Sensed) -> Lag:
        """How far behind a newly accepted message came."""
        stamp, newest = sensed.stamp, state.newest
        overtaken = newest is not None and stamp.sequence < newest.stamp.sequence
        silence_ns = self.contract.max_input_age_ns
        return state.backlog.after(stamp.time_ns, sensed.received_ns, silence_ns, overtaken)

    def _source(self, bound: BoundBody | None, sensed: Sensed) -> BoundBody:
        """The source after a good message: another one only after this one's silence."""
        silence_ns = self.contract.max_input_age_ns
        return bound_after(bound, sensed.stamp.sender, sensed.received_ns, silence_ns)

    def _push(self, frames: tuple[Retina, ...], retina: Retina) -> tuple[Retina, ...]:
        depth = self.contract.retina.frames
        return (*(frames or (retina,) * depth), retina)[-depth:]

    def _judge(self, state: State, stop: bool, now_ns: int) -> tuple[Verdict, str]:
        if stop:
            return Verdict.STOPPED, "asked to stop"
        if state.stopped:
            return Verdict.STOPPED, state.stopped
        if state.overrun:
            return Verdict.OVERRUN, state.overrun
        if state.fault:
            return Verdict.INVALID_INPUT, state.fault
        if state.still.driven_ns and self._is_frozen(state.still):
            return Verdict.INVALID_INPUT, self._frozen_words()
        stranger = self._stranger(state, now_ns)
        if stranger:
            return Verdict.TWO_SOURCES, f"another {stranger} sends as well"
        if state.newest is None:
            return Verdict.NO_INPUT, "nothing has arrived"
        age_ns, limit_ns = now_ns - state.newest.received_ns, self.contract.max_input_age_ns
        behind_ns = state.backlog.behind_ns
        if age_ns > limit_ns:
            return Verdict.STALE_INPUT, f"older than {limit_ns / 1e6:g} ms"
        if age_ns + behind_ns > limit_ns:
            return Verdict.STALE_INPUT, backlog_in_words(behind_ns)
        wanted = self.contract.recovery_inputs
        if state.streak < wanted:
            return Verdict.RECOVERING, f"{state.streak} of {wanted} good inputs in a row"
        return Verdict.OK, ""

    def _is_frozen(self, still: Still) -> bool:
        settings = self.sense.settings
        if settings is None or settings.frozen_after_s is None:
            return False
        return still.driven_ns > settings.frozen_after_s * 1e9

    def _frozen_words(self) -> str:
        limit_s = (self.sense.settings or DEFAULT).frozen_after_s
        return (
            f"the same {self.sense.topic.name} all the time, while the body was told to drive for "
            f"{limit_s:g} s (--frozen-after): does its driver hang?"
        )

    def _stranger(self, state: State, now_ns: int) -> str:
        """What spoke beside the sender that it is bound to; empty if nothing did."""
        if _was_answered(state.source, now_ns, self.contract.max_input_age_ns):
            return "body"
        if self.guard is None:
            return ""
        silence_ns = self.guard.settings.ranges_oldest_ns
        return "range sensor" * _was_answered(state.ranges.source, now_ns, silence_ns)

    def _ask(self, state: State, slot: int) -> Outcome:
        stack: RetinaStack = np.array(state.frames)  # `np.stack` takes three times as long
        memory = self._memory(state)
        given = stack.tobytes(), () if memory is None else tuple(memory[0].tolist())
        try:
            q_values, winner, following = self._decide(stack, memory)
            values = tuple(q_values.tolist())
        except DecisionEndedError as error:
            error.policy_hash = self.policy_hash
            raise
        except Exception as error:  # whatever a policy does, the body gets its safe command
            return Outcome(Verdict.POLICY_FAULT, type(error).__name__, *given)
        if not _is_finite(values, following) or not 0 <= winner < len(self.contract.actions):
            reason = "values not finite, or no such action"
            return Outcome(Verdict.POLICY_FAULT, reason, *given, values)
        hold = self._choose(state.hold, values, winner, slot)
        return Outcome(Verdict.OK, "", *given, values, winner, hold, following, hold.action)

    def _guarded(
        self, guard: Guard, wanted: Outcome, hold: Hold, state: State, now_ns: int
    ) -> Outcome:
        """What is done of what the policy wants: whatever else it is ends the hold."""
        beams, age_s = self._measured(guard, state, now_ns)
        moving = self._moving(state, now_ns)
        answer = guard.answer(hold.action, wanted.q_values, beams, age_s, moving)
        if answer.action == hold.action and answer.share == 1.0:
            return wanted
        wish = self.contract.actions[hold.action].name
        if answer.action is None:
            lack = self.lack_of_ranges(state, now_ns)
            reason = lack or f"{wish} is not free, nor is anything else"
            return replace(
                wanted, verdict=Verdict.STUCK, reason=reason, hold=None, action=SAFE_ACTION
            )
        instead = self.contract.actions[answer.action].name
        reason = f"{wish} is not free: {instead} at {answer.share:.0%}"
        return replace(
            wanted,
            verdict=Verdict.GUARDED,
            reason=reason,
            hold=None,
            action=answer.action,
            share=answer.share,
        )

    def _measured(self, guard: Guard, state: State, now_ns: int) -> tuple[Beams | None, float]:
        """What was measured last, and how long ago, in seconds."""
        if guard.settings.ranges:
            ranged = state.ranges.newest
            beams = beams_of(state.ranges, now_ns, guard.settings.ranges_oldest_ns)
            behind_ns = state.ranges.backlog.behind_ns
            return beams, 0.0 if ranged is None else _age_s(ranged.received_ns, behind_ns, now_ns)
        newest = state.newest
        if newest is None:
            return None, 0.0
        behind_ns = state.backlog.behind_ns
        return self.sense.beams(newest), _age_s(newest.received_ns, behind_ns, now_ns)

    def _memory(self, state: State) -> Memories | None:
        spec = self.contract.state
        if not spec.size or state.memory is not None:
            return state.memory
        return np.array([spec.start_value], np.float32)

    def _decide(
        self, stack: RetinaStack, memory: Memories | None
    ) -> tuple[QValues, int, Memories | None]:
        """Q-values (actions,), the winner, and the next memory (1, size), if there is one."""
        if memory is None:
            q_values, winners = cast("Policy", self.policy).decide(stack[np.newaxis])
            return q_values[0], int(winners[0]), None
        remembering = cast("RememberingPolicy", self.policy)
        q_values, winners, following = remembering.decide(stack[np.newaxis], memory)
        return q_values[0], int(winners[0]), following

    def _choose(
        self, held: Hold | None, q_values: tuple[float, ...], winner: int, slot: int
    ) -> Hold:
        contract = self.contract
        hold_slots, margin, least_lead = contract.hold_slots, contract.margin, contract.least_lead
        return choose(held, q_values, winner, slot, hold_slots, margin, least_lead)

    def _remember(self, state: State, outcome: Outcome, decision: Decision) -> State:
        """The state after a tick. Any verdict but OK ends a hold.

        Where the policy was not asked, or failed, its memory begins anew.
        """
        is_good = outcome.verdict in ASKED
        still, now_ns = state.still, decision.now_ns
        return State(
            index=state.index + 1,
            streak=0 if self._ends_streak(outcome.verdict) else state.streak,
            newest=state.newest,
            frames=state.frames,
            fault=state.fault,
            memory=state.memory if is_good else None,
            following=outcome.following,
            hold=outcome.hold,
            stopped=state.stopped,
            source=state.source,
            moving=self._told(state, decision),
            ranges=state.ranges,
            backlog=state.backlog,
            still=still.told(not decision.command.is_safe, now_ns) if still.picture else still,
            serving=state.serving,
            drove=decision.command.moves,
        )

    def _ends_streak(self, verdict: Verdict) -> bool:
        if verdict is Verdict.OVERRUN:
            return self.rules.recovers_after_overrun
        return verdict in _ENDS_STREAKS

    def _conclude(self, state: State, inputs: Inputs, now_ns: int, outcome: Outcome) -> Decision:
        used = _input_of(state.newest, state.backlog.behind_ns, now_ns)
        action, verdict = outcome.action, outcome.verdict
        if action != SAFE_ACTION and used is not None:
            motion, valid_for_ns = self.contract.actions[action], self.contract.max_input_age_ns
            body = state.source.sender if state.source is not None else b""
            command = drive_command(
                state.index, action, motion, used, valid_for_ns, body, verdict, outcome.share
            )
        else:
            command = safe_command(state.index, verdict, self.contract.safe_command)
        return Decision(
            index=state.index,
            slot=inputs.slot,
            now_ns=now_ns,
            inputs=len(inputs.messages),
            input=used,
            retina=outcome.stack,
            q_values=outcome.q_values,
            winner=outcome.winner,
            action=action,
            verdict=verdict,
            reason=outcome.reason,
            command=command,
            policy_hash=self.policy_hash,
            state=outcome.memory,
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


def _was_answered(bound: BoundBody | None, now_ns: int, silence_ns: int) -> bool:
    """Whether somebody else spoke on the topic of a bound sender a short while ago."""
    stranger_ns = None if bound is None else bound.stranger_ns
    return stranger_ns is not None and now_ns - stranger_ns <= silence_ns


def _is_finite(q_values: tuple[float, ...], following: Memories | None) -> bool:
    remembered = following is None or bool(np.isfinite(following).all())
    return remembered and all(map(math.isfinite, q_values))


def _age_s(received_ns: int, behind_ns: int, now_ns: int) -> float:
    return (max(0, now_ns - received_ns) + behind_ns) * 1e-9


def _input_of(newest: Sensed | None, behind_ns: int, now_ns: int) -> Input | None:
    if newest is None:
        return None
    stamp, received_ns = newest.stamp, newest.received_ns
    return Input(stamp.sequence, stamp.time_ns, received_ns, now_ns - received_ns + behind_ns)
