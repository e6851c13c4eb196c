"""`reflexarc run`: the sense–act loop with one policy."""

import uuid
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from reflexarc.loading import uncollected
from reflexarc.terminal.output import aside, console, facts, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc.wiring.guard_flags import GuardFlags
from reflexarc.wiring.keeping_logs.black_box_flags import BlackBoxFlags
from reflexarc.wiring.keeping_logs.recording_flags import RecordingFlags
from reflexarc.wiring.keeping_logs.run_summary import summary_as_dict, summary_in_words
from reflexarc.wiring.running.candidate_flags import CandidateFlags, others_of
from reflexarc.wiring.running.candidate_summary import candidates_as_dict, candidates_in_words
from reflexarc.wiring.running.pacing_flags import PacingFlags
from reflexarc.wiring.running.realtime_flags import RealtimeFlags
from reflexarc.wiring.running.trusted_policy_flags import TrustedPolicyFlags
from reflexarc.wiring.scan_flags import ScanFlags
from reflexarc.wiring.sense_flags import SenseFlags
from reflexarc.wiring.sight.metrics_flags import MetricsFlags
from reflexarc.wiring.watching import Watching
from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.contract.stopping import check_speed
from reflexarc_runtime.errors import NoRouterError, UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from contextlib import AbstractContextManager

    from reflexarc.wiring.keeping_logs.outcome import Recording
    from reflexarc.wiring.keeping_logs.run_sinks import RunSinks
    from reflexarc.wiring.running.candidate_flags import WatchingPolicy
    from reflexarc.wiring.running.sense_act_loop import LoopFlags, LoopOutcome
    from reflexarc_logs.recording.black_box import BoxSpan
    from reflexarc_logs.recording.keeping import Keeping
    from reflexarc_logs.recording.recorder import Recorder
    from reflexarc_runtime.controller import Controller
    from reflexarc_runtime.metrics.feed import MetricsFeed
    from reflexarc_runtime.policy.policy import LoadedPolicy


@dataclass(frozen=True)
class RunCommand:
    """Run a policy: sense, decide, act, at the contract's rate, until Ctrl-C.

    With --pace input a tick begins as soon as an input arrives, never more often than that rate.
    Whatever comes in, the body gets a command at every tick: the policy's while its input is good
    and fresh, the contract's safe command otherwise. A policy that asks for more speed or patience
    than is usual, or whose safe command moves, is refused unless flags allow it; so is one that
    takes longer than a period to decide. A guard, which has learned nothing, lets only pass what is
    free by the ranges that were measured; where the input tells none, it needs a range sensor
    beside it, --guard-ranges scan, or must be left out: --no-guard. SIGINT, SIGTERM, SIGQUIT and
    SIGHUP end in a safe command and a finished log. A loop that hangs is stopped by its watchdog.
    Exit status 1: the recording failed, or a part of it is missing; the robot drove all the same.

    Examples:
      reflexarc run runs/reflex-0/policy.onnx
      reflexarc run runs/reflex-0/policy.onnx --record runs/drive.mcap
      reflexarc run runs/reflex-0/policy.onnx --record runs/monday --rotate-s 600 --keep-mb 2000
      reflexarc run runs/reflex-0/policy.onnx --black-box 30 -o runs/incidents
      reflexarc run runs/reflex-0/policy.onnx --input scan --robot rover1
      reflexarc run runs/reflex-0/policy.onnx --pace input
      reflexarc run runs/reflex-0/policy.onnx --realtime strict --cpu 1
      reflexarc run racer.onnx --max-speed-mps 30
      reflexarc run --config /etc/reflexarc/robot0.toml
      reflexarc run rover.onnx --input scan --mount 0.1 0 180 --no-return zero
    """

    policy: tyro.conf.Positional[Path]
    """The exported policy (ONNX)."""
    trusting: tyro.conf.OmitArgPrefixes[TrustedPolicyFlags] = field(
        default_factory=TrustedPolicyFlags
    )
    input: Literal["retina", "scan"] = "retina"
    """Which sensor stream to decide on."""
    backend: Literal["numpy", "onnxruntime"] = "numpy"
    """What computes the policy: numpy gives the same bits everywhere."""
    lockstep: bool = False
    """One tick an input, on the input's own time."""
    record: Path | None = None
    """Record everything to this MCAP file; after a failure, or with --rotate-mb, --rotate-s or
    --keep-mb, it goes on in NAME.part2.mcap. A folder, made with these flags, takes many runs."""
    recording: tyro.conf.OmitArgPrefixes[RecordingFlags] = field(default_factory=RecordingFlags)
    box: tyro.conf.OmitArgPrefixes[BlackBoxFlags] = field(default_factory=BlackBoxFlags)
    ticks: int | None = None
    """End after so many ticks; by default, at Ctrl-C."""
    punctuality: tyro.conf.OmitArgPrefixes[RealtimeFlags] = field(default_factory=RealtimeFlags)
    bounds: Bounds = field(default_factory=Bounds)
    sensing: SenseFlags = field(default_factory=SenseFlags)
    allow_fast: bool = False
    """Drive faster than the eye of the policy, its delays and its body's brakes allow."""
    guarding: GuardFlags = field(default_factory=GuardFlags)
    pacing: tyro.conf.OmitArgPrefixes[PacingFlags] = field(default_factory=PacingFlags)
    watching: Watching = field(default_factory=Watching)
    candidates: tyro.conf.OmitArgPrefixes[CandidateFlags] = field(default_factory=CandidateFlags)
    metering: tyro.conf.OmitArgPrefixes[MetricsFlags] = field(default_factory=MetricsFlags)
    joining: Joining = field(default_factory=Joining)
    config: Path | None = None
    """TOML file with flags, named as here; what the command line says counts more."""
    show_config: bool = False
    """Print all settings as such a file, and end."""
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Tick until the end, then say how it went."""
        from reflexarc_runtime.service.manager import manager_of, say_where_it_dies

        if self.show_config:
            from reflexarc.config_file.printing import as_toml

            print(as_toml(self), end="")
            return 0
        manager = manager_of()  # before other processes start: they are no service
        say_where_it_dies(manager)
        policy, controller, watcher = self.prepared()
        from reflexarc.wiring.running.sense_act_loop import SenseActLoop
        from reflexarc_runtime.messages.topics import RUNTIME_NODE

        run_id = uuid.uuid4().hex
        try:
            with (
                StopFlag() as stop,
                self.metering.feed("reflexarc run") as metrics,
                self._sinks(policy, run_id, watcher) as sinks,
                self.joining.bus_in_time(
                    RUNTIME_NODE,
                    stop,
                    "reflexarc run",
                    lockstep=self.lockstep,
                    waiting=manager.waiting,
                ) as bus,
            ):
                flags = self._loop_flags(watcher, metrics)
                loop = SenseActLoop(bus, controller, policy, sinks, run_id, flags, manager)
                outcome = loop.run(stop, self.ticks)
        except NoRouterError:  # asked to end before there was one, which is no failure
            return 0
        self._tell(outcome, sinks.recordings)
        return int(any(recording.failed for recording in sinks.recordings.values()))

    def prepared(self) -> "tuple[LoadedPolicy, Controller, WatchingPolicy | None]":
        """All that a run is made of before it is recorded, and joins the bus.

        Raises:
            ReflexarcError: flags, policies or files with which it cannot begin.
        """
        self._check_flags()
        with uncollected():
            policy = self._tried_policy()
        for note in policy.notes:
            aside.print(f"reflexarc run: {note}", soft_wrap=True)
        controller = self._controller_of(policy)
        shadow = self.trusting.check_watching(self.candidates.shadow)
        watcher = self.candidates.watcher(policy.contract, self.backend, shadow)
        self.joining.check()
        return policy, controller, watcher

    def _controller_of(self, policy: "LoadedPolicy") -> "Controller":
        """What decides by the policy, on the input and behind the guard that the flags name."""
        from reflexarc_runtime.controller import Controller
        from reflexarc_runtime.guard import asks_the_input
        from reflexarc_runtime.sensing.senses import sense_for

        contract, guard = policy.contract, self.guarding.guard_for(policy.contract)
        guarded = asks_the_input(guard)
        sense = sense_for(self.input, contract.retina, self.sensing.settings, guarded=guarded)
        return Controller(policy, contract, sense, policy.policy_hash, guard=guard)

    def _tried_policy(self) -> "LoadedPolicy":
        """Load the policy, after a process of its own has."""
        from reflexarc.wiring.running.driving_policy import tried_policy
        from reflexarc_runtime.loop.trials.trial import check_fits

        accepted = self.trusting.check_file(self.policy)
        finding, policy = tried_policy(self.policy, accepted, self.backend, self.bounds)
        check_fits(finding, policy, in_real_time=not self.lockstep)
        warning = check_speed(policy.contract, allow=self.allow_fast)
        if warning:
            aside.print(f"reflexarc run: {warning}", soft_wrap=True)
        return policy

    def _check_flags(self) -> None:
        self.trusting.check()
        self.watching.check()
        self.pacing.check(lockstep=self.lockstep)
        self.metering.check()
        if self.recording.keeping("reflexarc run").in_parts and self.record is None:
            raise UsageError(
                "--rotate-mb, --rotate-s, --keep-mb: expected --record PATH beside them"
            )
        _ = self.box.span
        looks_at_scans = self.input == "scan" or self.guarding.guard_ranges == "scan"
        if self.sensing.scanner != ScanFlags() and not looks_at_scans:
            raise UsageError(
                "the flags of a scanner (--mount, --no-return …) say nothing of retinas: "
                "expected --input scan or --guard-ranges scan beside them"
            )
        self.guarding.check(self.input, lockstep=self.lockstep)
        if self.ticks is not None and self.ticks < 1:
            raise UsageError(f"--ticks: expected 1 or more, got {self.ticks}")
        self.punctuality.check(lockstep=self.lockstep)

    def _loop_flags(
        self, watcher: "WatchingPolicy | None", metrics: "MetricsFeed | None"
    ) -> "LoopFlags":
        from reflexarc.wiring.running.sense_act_loop import LoopFlags
        from reflexarc_runtime.loop.candidates.swap_desk import SwapRules

        swaps = SwapRules(
            self.candidates.why_no_swap(lockstep=self.lockstep),
            self.backend,
            self.bounds,
            lambda contract: check_speed(contract, allow=self.allow_fast),
            self.trusting.refuses(),
        )

        return LoopFlags(
            policy_name=str(self.policy),
            sensor=self.input,
            backend=self.backend,
            lockstep=self.lockstep,
            realtime=self.punctuality.settings,
            guard=self.guarding.state,
            watching=self.watching,
            pacing=self.pacing,
            swaps=swaps,
            watcher=watcher,
            metrics=metrics,
        )

    def _sinks(
        self, policy: "LoadedPolicy", run_id: str, watcher: "WatchingPolicy | None"
    ) -> "AbstractContextManager[RunSinks]":
        """What the run is recorded by."""
        from reflexarc.wiring.keeping_logs.recorders import recorder_of_run
        from reflexarc.wiring.keeping_logs.run_sinks import run_sinks

        def make(path: Path, keeping: "Keeping", box: "BoxSpan | None") -> "Recorder":
            return recorder_of_run(
                path,
                policy,
                run_id=run_id,
                robot=self.joining.robot,
                sensor=self.input,
                lockstep=self.lockstep,
                pace=self.pacing.name(lockstep=self.lockstep),
                guard=self.guarding.settings_for(policy.contract),
                senses=self.sensing.settings,
                keeping=keeping,
                box=box,
                others=others_of(watcher),
            )

        return run_sinks(self.record, self.recording, self.box, make)

    def _tell(self, outcome: "LoopOutcome", recordings: "Mapping[str, Recording]") -> None:
        from reflexarc.terminal.cadence_table import cadence_table
        from reflexarc_runtime.loop.realtime.grant import in_words

        summary, candidates = outcome.summary, (outcome.shadow, outcome.served)
        if self.json:
            said = summary_as_dict(summary, recordings)
            said["realtime"] = [asdict(grant) for grant in outcome.granted]
            print_json({**said, **candidates_as_dict(*candidates)})
        else:
            words = summary_in_words(summary, recordings)
            words["real time"] = in_words(outcome.granted)
            console.print(facts({**words, **candidates_in_words(*candidates)}))
            if summary.phases and not self.lockstep:
                console.print(cadence_table(summary.phases))
