"""Connects the loop of `reflexarc run` to bus, watchdog, notices and sinks, and runs it."""

from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from reflexarc.terminal.output import aside, plain
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.awaiting import awaiting_input, wait_for_body
from reflexarc.wiring.keeping_logs.run_sinks import RunSinks
from reflexarc.wiring.rivals import Rivals
from reflexarc.wiring.waiting import Arrival
from reflexarc.wiring.watching import Watching
from reflexarc_runtime.bus import Bus, Publisher
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.loop import realtime
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.monitor import Summary
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.notices.input_notices import Notices
from reflexarc_runtime.loop.outlets import NoOutlet, Outlets
from reflexarc_runtime.loop.pacer import LockstepPacer, Pacer, RatePacer
from reflexarc_runtime.loop.warm_up import warm_up
from reflexarc_runtime.loop.watch import Watch
from reflexarc_runtime.messages.topics import (
    COMMAND,
    LEASE,
    OVERHEARD,
    RELEASE,
    RESET,
    STATUS,
    STOP,
    TICK,
)
from reflexarc_runtime.messages.wire import Message, at_source_time
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.service.manager import Manager, NoManager


@dataclass(frozen=True)
class LoopFlags:
    """How the loop runs, as the flags of the command say."""

    policy_name: str
    """As the user gave it."""
    sensor: str
    """`retina` or `scan`."""
    backend: str
    lockstep: bool
    fifo: int
    guard: str
    """What the status says of the guard."""
    watching: Watching


@dataclass(frozen=True)
class SenseActLoop:
    """One loop on one bus, until it is stopped."""

    bus: Bus
    controller: Controller
    policy: LoadedPolicy
    sinks: RunSinks
    run_id: str
    flags: LoopFlags
    manager: Manager = field(default_factory=NoManager)
    """Whoever started this as a service."""

    def run(self, stop: StopFlag, max_ticks: int | None) -> Summary:
        """Listen, announce the runtime, and tick until asked to stop, or `max_ticks` times."""
        bus, flags, inbox = self.bus, self.flags, Inbox()
        command = bus.publisher(COMMAND)
        outlets = self._outlets(command)
        self._listen_to_the_rest()
        bus.offer_policy(self.policy.data)
        if flags.lockstep:
            wait_for_body(bus, command, stop)
        came = Arrival(inbox.put)
        self._listen_to_people(inbox)
        if flags.lockstep:  # its body waits for every answer, and no time passes
            self._listen_to_senses(inbox, came)
        watching = self._watching(inbox)
        said = "; ".join(realtime.prepare(flags.fifo))  # the watchdog's thread inherits it
        notices = Notices(self._say, self.controller.contract, flags.sensor)
        key = self.controller.sense.topic.key(bus.robot)
        waiting = awaiting_input(bus, flags.sensor, key, came)
        # The watchdog ends first: what it watches has ended, and the others take a moment to.
        with notices, waiting, watching as watch:
            self._say(f"{flags.policy_name} on {flags.backend}; {said}; watchdog {watch.state}")
            node = self._node(inbox, outlets, watch, notices)
            if not flags.lockstep:
                warm_up(self.controller)
                self._listen_to_senses(inbox, came)
            summary = node.run(stop, max_ticks)
        self.manager.ending()
        return summary

    def _outlets(self, command: Publisher) -> Outlets:
        bus = self.bus
        release = NoOutlet() if self.flags.lockstep else bus.publisher(RELEASE)
        return Outlets(command, bus.publisher(TICK), bus.publisher(STATUS), release)

    def _listen_to_senses(self, inbox: Inbox, came: Arrival) -> None:
        """Hand the loop what it decides on, as the last thing before its first tick.

        Who listens while the rest of a start keeps this process busy hears late what came in time:
        the first delays go up and down as those of a sender whose clock steps do, and what follows
        counts as a backlog for a minute or two.
        """
        self.bus.subscribe([self.controller.sense.topic], came.hear)
        if self.controller.ranges_topic is not None:
            self.bus.subscribe([self.controller.ranges_topic], inbox.put)

    def _listen_to_people(self, inbox: Inbox) -> None:
        """Hand the loop what stops it; say whom the body obeys in place of this runtime."""
        bus = self.bus
        bus.subscribe([STOP, RESET], inbox.put)
        if not self.flags.lockstep:  # where all have one name
            bus.subscribe([LEASE], Rivals(bus.sender, self._say, bus.robot).hear)

    def _listen_to_the_rest(self) -> None:
        """Record the streams that the loop does not decide on; they bypass the inbox."""
        sinks, is_lockstep = self.sinks, self.flags.lockstep
        if not sinks.takes_any:
            return

        def keep(message: Message) -> None:
            sinks.put(at_source_time(message) if is_lockstep else message)

        self.bus.subscribe(OVERHEARD, keep)

    def _watching(self, inbox: Inbox) -> AbstractContextManager[Watch]:
        return self.flags.watching.watch(
            self.bus,
            inbox,
            self.policy,
            robot=self.bus.robot,
            run_id=self.run_id,
            lockstep=self.flags.lockstep,
        )

    def _node(self, inbox: Inbox, outlets: Outlets, watch: Watch, notices: Notices) -> Node:
        """The loop, with all that it is connected to."""

        def saw(decision: Decision) -> None:
            notices.saw(decision)
            self.manager.ticked(decision.now_ns, lambda: decision.verdict.name)

        return Node(
            self.controller,
            self._pacer(inbox),
            outlets,
            sink=self.sinks,
            robot=self.bus.robot,
            run_id=self.run_id,
            sender=self.bus.sender,
            overflows=lambda: inbox.overflows,
            watch=watch,
            guard=self.flags.guard,
            saw=saw,
            sensor=notices.sensor,
        )

    def _pacer(self, inbox: Inbox) -> Pacer:
        if self.flags.lockstep:
            return LockstepPacer(inbox)
        return RatePacer(self.controller.contract.rate_hz, MonotonicClock(), inbox)

    def _say(self, words: str) -> None:
        aside.print(f"reflexarc run: {plain(words)}", soft_wrap=True)
