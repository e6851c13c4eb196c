"""The sense–act loop: wait, receive, decide, publish, record.

The node connects the parts: the pacer says when a tick begins, the controller decides, the outlets
publish the command, the sink records.
"""

from collections.abc import Callable
from dataclasses import replace

from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Decision, Timing, Verdict, safe_command
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.cadence.histogram import ABSENT
from reflexarc_runtime.loop.cadence.monitor import Monitor, Summary
from reflexarc_runtime.loop.notices.flood_notice import FloodNotice
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.pacer import Pacer, Wakeup
from reflexarc_runtime.loop.sink import NoSink, Sink
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.loop.tick_record import LoopIdentity, TickRecord
from reflexarc_runtime.loop.warm_up import warm_up
from reflexarc_runtime.loop.watch import NoWatch, Watch
from reflexarc_runtime.messages.codec import Status, encode_command, encode_status
from reflexarc_runtime.messages.controls import encode_overrun, encode_own_release, encode_stop
from reflexarc_runtime.messages.tick_encoder import TickEncoder
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT, OVERRUN, RUNTIME_NODE, STOP
from reflexarc_runtime.messages.wire import (
    NO_SENDER,
    Message,
    Stamp,
    pack_stamp,
    protobuf_encoding,
)
from reflexarc_runtime.serving.swapping import AnyController

END_OF_RUN = "the runtime was asked to end"
"""Reason of the stop that the loop gives itself."""


class Node:
    """Runs a controller at the pacer's pace."""

    def __init__(
        self,
        controller: AnyController,
        pacer: Pacer,
        outlets: Outlets,
        *,
        sink: Sink | None = None,
        robot: str = DEFAULT_ROBOT,
        run_id: str = "",
        sender: bytes = NO_SENDER,
        overflows: Callable[[], int] = lambda: 0,
        guard: str = "",
        watch: Watch | None = None,
        saw: Callable[[Decision], None] = lambda decision: None,
        sensor: Callable[[int], str] = lambda now_ns: "",
        made_of: Callable[[State, Inputs, int, int], None] = lambda before, inputs, now, took: None,
        shadow: Callable[[], str] = lambda: "",
        realtime: str = "",
        policy_name: Callable[[str], str] = lambda policy_hash: "",
        pace: str = "",
    ) -> None:
        self._controller = controller
        self._pacer = pacer
        self._outlets = outlets
        self._sink: Sink = sink or NoSink()
        self._identity = LoopIdentity(robot, sender)
        self._run_id = run_id
        self._sender = sender
        self._overflows = overflows
        self._guard = guard or ("off" if controller.guard is None else "on")
        self._watch: Watch = watch or NoWatch()
        self._saw, self._sensor, self._made_of, self._shadow = saw, sensor, made_of, shadow
        self._realtime = realtime
        self._policy_name, self._pace = policy_name, pace
        self._flood = FloodNotice(f"the runtime of {robot}")
        self._monitor = Monitor()
        self._encoder = TickEncoder()
        self._state = State()
        self._record_ns = ABSENT
        self._is_ending = False
        self._every_second = Throttle(at_once=False)
        self._keyframes = Throttle()
        self._last_ns: int | None = None
        self._postponed: tuple[Message, ...] = ()

    def run(
        self, should_stop: Callable[[], bool] = lambda: False, max_ticks: int | None = None
    ) -> Summary:
        """Tick until asked to stop, or `max_ticks` times.

        The last command is the safe one, whatever is raised.
        """
        try:
            warm_up(self._controller)
            while max_ticks is None or self._state.index < max_ticks:
                wakeup = self._pacer.wait(should_stop)
                if wakeup is None:
                    break
                self._tick(wakeup)
        finally:
            self._end()
        return self._monitor.summary()

    def _end(self) -> None:
        """Make the last tick, which is a stop, and give the lease back.

        Where even that tick fails, send the safe command.
        """
        self._is_ending = True
        try:
            self._tick(self._stopped(self._pacer.farewell()))
        except BaseException:
            safe = self._controller.contract.safe_command
            last = safe_command(self._state.index, Verdict.STOPPED, safe)
            self._outlets.command.put(encode_command(last), self._pacer.now_ns())
            raise
        finally:  # the next runtime need not wait until this one has been silent for long enough
            self._outlets.release.put(encode_own_release(END_OF_RUN), self._pacer.now_ns())

    def _stopped(self, wakeup: Wakeup) -> Wakeup:
        """The wake-up with a stop behind its messages: what ends the run is in the log as well."""
        stamp = Stamp(0, wakeup.now_ns, self._sender)
        key, encoding = STOP.key(self._identity.robot), protobuf_encoding(STOP.schema)
        payload, attachment = encode_stop(END_OF_RUN), pack_stamp(stamp)
        stop = Message(key, payload, encoding, attachment, stamp.time_ns)
        return replace(wakeup, messages=(*wakeup.messages, stop))

    def _tick(self, wakeup: Wakeup) -> None:
        self._watch.begin(wakeup.now_ns)
        if self._postponed:
            wakeup = replace(wakeup, messages=(*self._postponed, *wakeup.messages))
        try:
            self._monitor.missed(wakeup.missed)
            self._make_tick(wakeup)
            self._postponed = ()
        except DecisionEndedError as ended:
            self._monitor.missed(1)
            self._postponed = (*wakeup.messages, self._ended(ended.policy_hash, wakeup.now_ns))
        self._watch.rest(self._pacer.now_ns())

    def _ended(self, policy_hash: str, begun_ns: int) -> Message:
        """What the next tick is told, behind what this one was given, so that it is in the log."""
        key, encoding = OVERRUN.key(self._identity.robot), protobuf_encoding(OVERRUN.schema)
        payload = encode_overrun(begun_ns, self._pacer.now_ns() - begun_ns, policy_hash)
        return Message(
            key, payload, encoding, pack_stamp(Stamp(0, begun_ns, self._sender)), begun_ns
        )

    def _make_tick(self, wakeup: Wakeup) -> None:
        before = self._state
        inputs = Inputs(wakeup.messages, wakeup.slot)
        following, decision = self._controller.step(before, inputs, wakeup.now_ns)
        decided_ns = self._pacer.now_ns()
        command = self._publish(decision)
        published_ns = self._pacer.now_ns()
        timing = Timing(
            deadline_ns=wakeup.deadline_ns,
            wake_ns=wakeup.wake_ns,
            receive_ns=wakeup.receive_ns,
            decide_ns=decided_ns - wakeup.now_ns,
            publish_ns=published_ns - decided_ns,
            record_ns=self._record_ns,
        )
        tick = self._encoder.encode(decision, timing)
        self._outlets.tick.put(tick, decision.now_ns)
        told_ns = self._pacer.now_ns()
        self._remember(before, wakeup)
        index, now_ns = decision.index, decision.now_ns
        self._sink.put_tick(
            TickRecord(wakeup.messages, tick, command, index, now_ns, self._identity)
        )
        self._state = following  # only now: a tick that failed on the way is not in the log either
        self._record_ns = self._pacer.now_ns() - told_ns
        self._count(decision, timing)
        self._saw(decision)
        self._made_of(before, inputs, wakeup.now_ns, timing.decide_ns)
        self._report(wakeup.now_ns, decision)

    def _publish(self, decision: Decision) -> bytes | None:
        """Send the command; None if it was not sent, as the watchdog spoke in its place."""
        command = encode_command(decision.command)
        outlet, is_safe = self._outlets.command, decision.command.is_safe
        was_sent = self._watch.let_pass(outlet, command, decision.now_ns, is_safe)
        return command if was_sent else None

    def _remember(self, before: State, wakeup: Wakeup) -> None:
        """Once a second, and at the first tick, record what the controller knew before this one.

        It stands behind the tick before and in front of this tick's messages, in the file and in
        time.
        """
        if self._keyframes.is_due(wakeup.now_ns):
            times_ns = [message.received_ns for message in wakeup.messages]
            earliest_ns = min([wakeup.now_ns, *times_ns])
            at_ns = earliest_ns if self._last_ns is None else self._last_ns
            self._sink.put_keyframe(
                Keyframe(before, at_ns, self._controller.policy_hash, self._sender)
            )
        self._last_ns = wakeup.now_ns

    def _count(self, decision: Decision, timing: Timing) -> None:
        if self._is_ending:
            self._monitor.ended(decision)
        else:
            self._monitor.saw(decision, timing)

    def _report(self, now_ns: int, decision: Decision) -> None:
        if self._every_second.is_due(now_ns):
            self._flood.look(self._overflows())
            self._outlets.status.put(encode_status(self._status(now_ns, decision)), now_ns)

    def _status(self, now_ns: int, decision: Decision) -> Status:
        period = self._monitor.period()
        lack = self._controller.lack_of_ranges(self._state, now_ns)
        contract, acted = self._controller.contract, decision.action
        return Status(
            node=RUNTIME_NODE,
            run_id=self._run_id,
            policy_hash=decision.policy_hash,
            ticks=period.ticks,
            rate_hz=period.rate_hz,
            lateness_p50_ns=period.lateness_p50_ns,
            lateness_p99_ns=period.lateness_p99_ns,
            lateness_max_ns=period.lateness_max_ns,
            skipped_slots=period.skipped_slots,
            inbox_overflows=self._overflows(),
            verdicts=tuple(period.verdicts.items()),
            recording=self._sink.state,
            guard=f"{self._guard}: {lack}" if lack else self._guard,
            watchdog=self._watch.state,
            sensor=self._sensor(now_ns),
            phases=tuple(period.phases.items()),
            shadow=self._shadow(),
            realtime=self._realtime,
            action=contract.actions[acted].name if acted >= 0 else "",
            verdict=int(decision.verdict),
            policy=self._policy_name(decision.policy_hash),
            pace=self._pace,
            contract_rate_hz=contract.rate_hz,
        )
