"""Connects the loop of `reflexarc run` to bus, watchdog, notices and sinks, and runs it."""

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside, plain
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.awaiting import awaiting_input, wait_for_body
from reflexarc.wiring.keeping_logs.run_sinks import RunSinks
from reflexarc.wiring.rivals import Rivals
from reflexarc.wiring.running.candidate_flags import WatchingPolicy, others_of
from reflexarc.wiring.running.candidate_flags import watching as watching_policy
from reflexarc.wiring.running.pacing_flags import PacingFlags
from reflexarc.wiring.sight.metrics_flags import hear_metrics, said_to_metrics
from reflexarc.wiring.waiting import Arrival
from reflexarc.wiring.watching import Watching
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.loop.cadence.monitor import Summary
from reflexarc_runtime.loop.candidates.shadow import Shadow, ShadowAccount
from reflexarc_runtime.loop.candidates.swap_desk import SwapDesk, SwapRules
from reflexarc_runtime.loop.candidates.take_overs import TakeOvers
from reflexarc_runtime.loop.candidates.trial_helper import TrialHelper, Tries
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.notices.input_notices import Notices
from reflexarc_runtime.loop.outlets import NoOutlet, Outlets
from reflexarc_runtime.loop.pacing.pacer import Pacer
from reflexarc_runtime.loop.realtime import Realtime, RealtimeSettings
from reflexarc_runtime.loop.realtime.grant import Grant, require_all
from reflexarc_runtime.loop.rehearsal import Rehearsal
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
    SWAP,
    TICK,
)
from reflexarc_runtime.messages.wire import Message, at_source_time
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.service.manager import Manager, NoManager
from reflexarc_runtime.serving.swapping import AnyController, SwappingController

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus, Publisher
    from reflexarc_runtime.metrics.feed import MetricsFeed


@dataclass(frozen=True)
class LoopFlags:
    """How the loop runs, as the flags of the command say."""

    policy_name: str
    """As the user gave it."""
    sensor: str
    """`retina` or `scan`."""
    backend: str
    lockstep: bool
    realtime: RealtimeSettings
    """What is asked of the kernel."""
    guard: str
    """What the status says of the guard."""
    watching: Watching
    pacing: PacingFlags
    swaps: SwapRules
    """What is asked of a policy that shall take over."""
    watcher: WatchingPolicy | None = None
    """A policy that watches."""
    metrics: "MetricsFeed | None" = None
    """Who answers scrapes."""

    @property
    def short_name(self) -> str:
        """The policy's file and its folder: many are called policy.onnx."""
        return "/".join(Path(self.policy_name).parts[-2:])


@dataclass(frozen=True)
class LoopOutcome:
    """How a run went."""

    summary: Summary
    shadow: ShadowAccount | None
    """What the policy did that watched; None: there was none."""
    served: TakeOvers
    """Who took over, in order."""
    granted: tuple[Grant, ...]
    """What was asked of the kernel, and obtained."""


@dataclass(frozen=True)
class Candidates:
    """The policies beside the first one."""

    controller: AnyController
    desk: SwapDesk
    shadow: Shadow | None

    def saw(self, decision: Decision) -> None:
        """Take note of a tick; from the loop's thread, behind its command."""
        self.desk.saw(decision)
        if self.shadow is not None:
            self.shadow.saw(decision)

    def state(self) -> str:
        """What the shadow did so far; empty if there is none."""
        return "" if self.shadow is None else self.shadow.state


@dataclass(frozen=True)
class SenseActLoop:
    """One loop on one bus, until it is stopped."""

    bus: "Bus"
    controller: Controller
    policy: LoadedPolicy
    sinks: RunSinks
    run_id: str
    flags: LoopFlags
    manager: Manager = field(default_factory=NoManager)
    """Whoever started this as a service."""

    def run(self, stop: StopFlag, max_ticks: int | None) -> LoopOutcome:
        """Listen, announce the runtime, and tick until asked to stop, or `max_ticks` times."""
        bus, flags, inbox = self.bus, self.flags, Inbox()
        controllers: dict[str, Controller] = {}
        helper = TrialHelper()
        desk = self._swap_desk(inbox, controllers, helper)
        helping = nullcontext() if flags.swaps.forbidden else helper
        put, is_lockstep = self.sinks.put, flags.lockstep
        shadowing = watching_policy(flags.watcher, bus, put, lockstep=is_lockstep)
        realtime = Realtime(flags.realtime)
        with helping, shadowing as shadow:
            candidates = Candidates(self._swapping(controllers), desk, shadow)
            summary = self._drive(stop, max_ticks, inbox, candidates, realtime)
        account = None if shadow is None else shadow.account
        return LoopOutcome(summary, account, desk.served, realtime.grants)

    def _drive(
        self,
        stop: StopFlag,
        max_ticks: int | None,
        inbox: Inbox,
        candidates: Candidates,
        realtime: Realtime,
    ) -> Summary:
        bus, flags, desk = self.bus, self.flags, candidates.desk
        command = bus.publisher(COMMAND)
        outlets = self._outlets(command)
        self._listen_to_the_rest()
        bus.offer_policy(lambda: (desk.policy or self.policy).data)
        if flags.lockstep:
            wait_for_body(bus, command, stop)
        came = Arrival(inbox.put)
        self._listen_to_people(inbox)
        if flags.lockstep:  # its body waits for every answer, and no time passes
            self._listen_to_senses(inbox, came)
        watching = self._watching(inbox, desk)
        notices = Notices(self._say, self.controller.contract, flags.sensor)
        key = self.controller.sense.topic.key(bus.robot)
        waiting = awaiting_input(bus, flags.sensor, key, came)
        # The watchdog ends first: what it watches has ended, and the others take a moment to.
        # What the bus starts for requests and senses is asked for when it is there, last of all.
        with notices, waiting, watching as watch, realtime:
            if flags.realtime.strict:
                require_all(realtime.grants)
            bus.take_requests(desk.ask)
            said = realtime.words
            self._say(f"{flags.policy_name} on {flags.backend}; {said}; watchdog {watch.state}")
            node = self._node(candidates, inbox, outlets, watch, notices, said)
            if not flags.lockstep:
                warm_up(self.controller)
                self._listen_to_senses(inbox, came)
            realtime.take_in()
            summary = node.run(stop, max_ticks)
            self.manager.ending()  # at once: nothing feeds its watchdog while the others end
        return summary

    def _outlets(self, command: "Publisher") -> Outlets:
        bus = self.bus
        release = NoOutlet() if self.flags.lockstep else bus.publisher(RELEASE)
        status = said_to_metrics(self.flags.metrics, bus.publisher(STATUS), bus)
        return Outlets(command, bus.publisher(TICK), status, release)

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
        hear_metrics(self.flags.metrics, bus)
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

    def _swap_desk(
        self, inbox: Inbox, controllers: dict[str, Controller], tries: Tries
    ) -> SwapDesk:
        bus = self.bus
        said = bus.publisher(SWAP)

        def put(swap: Message) -> None:
            inbox.put(swap)
            said.put(swap.payload, swap.received_ns)

        return SwapDesk(
            self.controller,
            controllers,
            self.flags.swaps,
            tries,
            put,
            keep=self._keep_policies,
            now_ns=MonotonicClock().now_ns,
            robot=bus.robot,
            sender=bus.sender,
        )

    def _keep_policies(self, served: Mapping[str, bytes]) -> None:
        self.sinks.keep_policies({**served, **others_of(self.flags.watcher)})

    def _swapping(self, controllers: dict[str, Controller]) -> AnyController:
        if self.flags.swaps.forbidden:
            return self.controller
        return SwappingController(self.controller, controllers)

    def _watching(self, inbox: Inbox, desk: SwapDesk) -> AbstractContextManager[Watch]:
        return self.flags.watching.watch(
            self.bus,
            inbox,
            self.controller.contract,
            robot=self.bus.robot,
            run_id=self.run_id,
            lockstep=self.flags.lockstep,
            longest_wait_periods=self.flags.pacing.longest_wait_periods,
            serving=lambda: desk.serving,
            end_decision=desk.end_decision,
        )

    def _node(
        self,
        candidates: "Candidates",
        inbox: Inbox,
        outlets: Outlets,
        watch: Watch,
        notices: Notices,
        realtime: str,
    ) -> Node:
        """The loop, with all that it is connected to."""

        def saw(decision: Decision) -> None:
            notices.saw(decision)
            candidates.saw(decision)
            self.manager.ticked(decision.now_ns, lambda: decision.verdict.name)

        rehearsal = Rehearsal(candidates.controller)
        return Node(
            candidates.controller,
            self._pacer(inbox, rehearsal),
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
            made_of=rehearsal.note,
            shadow=candidates.state,
            realtime=realtime,
            policy_name=self._name_of,
            pace=self.flags.pacing.name(lockstep=self.flags.lockstep),
        )

    def _name_of(self, policy_hash: str) -> str:
        """The file of the policy of the start; another one that took over has none here."""
        return self.flags.short_name if policy_hash == self.policy.policy_hash else ""

    def _pacer(self, inbox: Inbox, rehearsal: Rehearsal) -> Pacer:
        flags, controller = self.flags, self.controller
        topic, is_lockstep = controller.sense.topic, flags.lockstep
        return flags.pacing.pacer(
            controller.contract, inbox, topic, rehearsal, lockstep=is_lockstep
        )

    def _say(self, words: str) -> None:
        aside.print(f"reflexarc run: {plain(words)}", soft_wrap=True)
