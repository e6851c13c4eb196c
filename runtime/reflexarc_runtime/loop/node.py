"""The sense–act loop: wait, receive, decide, publish, record.

The node connects the parts: the pacer says when a tick begins, the controller decides, the outlets
publish the command, the sink records.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from reflexarc_runtime.controller import Controller, Inputs, State
from reflexarc_runtime.decision import Decision, Timing
from reflexarc_runtime.loop.monitor import Monitor, Summary
from reflexarc_runtime.loop.pacer import Pacer, Wakeup
from reflexarc_runtime.loop.sink import NoSink, Sink
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.messages.codec import Status, encode_command, encode_status, encode_tick
from reflexarc_runtime.messages.topics import COMMAND, DEFAULT_ROBOT, TICK, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding


class Outlet(Protocol):
    """Publishes the messages of one topic."""

    def put(self, payload: bytes, time_ns: int) -> None:
        """Send one message; never blocks, never raises."""
        ...


@dataclass(frozen=True)
class Outlets:
    """The topics on which a runtime publishes."""

    command: Outlet
    tick: Outlet
    status: Outlet


class Node:
    """Runs a controller at the pacer's pace."""

    def __init__(
        self,
        controller: Controller,
        pacer: Pacer,
        outlets: Outlets,
        *,
        sink: Sink | None = None,
        robot: str = DEFAULT_ROBOT,
        run_id: str = "",
        overflows: Callable[[], int] = lambda: 0,
    ) -> None:
        self._controller = controller
        self._pacer = pacer
        self._outlets = outlets
        self._sink: Sink = sink or NoSink()
        self._robot = robot
        self._run_id = run_id
        self._overflows = overflows
        self._monitor = Monitor()
        self._state = State()
        self._record_ns = 0
        self._every_second = Throttle(at_once=False)

    def run(
        self, should_stop: Callable[[], bool] = lambda: False, max_ticks: int | None = None
    ) -> Summary:
        """Tick until asked to stop, or `max_ticks` times; the last command is the safe one."""
        while max_ticks is None or self._state.index < max_ticks:
            wakeup = self._pacer.wait(should_stop)
            if wakeup is None:
                break
            self._tick(wakeup)
        self._tick(self._pacer.farewell(), stop=True)
        return self._monitor.summary()

    def _tick(self, wakeup: Wakeup, *, stop: bool = False) -> None:
        inputs = Inputs(wakeup.messages, wakeup.slot, stop)
        began_ns = self._pacer.now_ns()
        self._state, decision = self._controller.step(self._state, inputs, wakeup.now_ns)
        decided_ns = self._pacer.now_ns()
        command = self._publish(decision)
        published_ns = self._pacer.now_ns()
        timing = Timing(
            deadline_ns=wakeup.deadline_ns,
            wake_ns=wakeup.wake_ns,
            receive_ns=wakeup.receive_ns,
            decide_ns=decided_ns - began_ns,
            publish_ns=published_ns - decided_ns,
            record_ns=self._record_ns,
        )
        self._record(wakeup.messages, decision, timing, command)
        self._record_ns = self._pacer.now_ns() - published_ns
        self._monitor.saw(decision, timing)
        self._report(wakeup.now_ns, decision.policy_hash)

    def _publish(self, decision: Decision) -> bytes:
        command = encode_command(decision.command)
        self._outlets.command.put(command, decision.now_ns)
        return command

    def _record(
        self, messages: tuple[Message, ...], decision: Decision, timing: Timing, command: bytes
    ) -> None:
        """Record the messages first, then the tick that used them: replay relies on this order."""
        tick = encode_tick(decision, timing)
        for message in messages:
            self._sink.put(message)
        self._sink.put(self._own(TICK, tick, decision))
        self._sink.put(self._own(COMMAND, command, decision))
        self._outlets.tick.put(tick, decision.now_ns)

    def _own(self, topic: Topic, payload: bytes, decision: Decision) -> Message:
        stamp = Stamp(decision.index, decision.now_ns)
        encoding = protobuf_encoding(topic.schema)
        key = topic.key(self._robot)
        return Message(key, payload, encoding, pack_stamp(stamp), decision.now_ns)

    def _report(self, now_ns: int, policy_hash: str) -> None:
        if not self._every_second.is_due(now_ns):
            return
        period = self._monitor.period()
        status = Status(
            node="runtime",
            run_id=self._run_id,
            policy_hash=policy_hash,
            ticks=period.ticks,
            rate_hz=period.rate_hz,
            lateness_p50_ns=period.lateness_p50_ns,
            lateness_p99_ns=period.lateness_p99_ns,
            lateness_max_ns=period.lateness_max_ns,
            skipped_slots=period.skipped_slots,
            inbox_overflows=self._overflows(),
            verdicts=tuple(period.verdicts.items()),
            recording=self._sink.state,
        )
        self._outlets.status.put(encode_status(status), now_ns)
