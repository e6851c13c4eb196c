"""`reflexarc sim`: a simulated body on the bus."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside, console, facts, plain, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining, asking_of, first_wanted, waiting_for_commands
from reflexarc.wiring.fleet import drive_together
from reflexarc_runtime.contract.body_fit import check_body
from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.wiring.asking import Asking, Wanted
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_sim_bridge.body.body import Body
    from reflexarc_sim_bridge.body.bridge import Journey
    from reflexarc_sim_bridge.body.faults.script import FaultScript
    from reflexarc_sim_bridge.body.following import Following
    from reflexarc_sim_bridge.body.latch import StopLatch
    from reflexarc_sim_bridge.worlds.world import World

MIN_RATE_HZ, MAX_RATE_HZ = 0.1, 1000.0
MAX_ROBOTS = 64


@dataclass(frozen=True)
class SimCommand:
    """Simulate a body on the bus: it sees and moves, in real time or in lockstep.

    It builds its eye from a policy's contract: from --policy, or from the runtime that it meets on
    the bus; under another runtime it builds it anew, and goes on where it is. A contract that asks
    for more speed or patience than is usual is refused, unless flags allow it. Without a fresh and
    valid command it stops by itself. It obeys one runtime at a time, keeps the limits of its world,
    and stands after `reflexarc stop` until `reflexarc reset`, even if it is started again.

    Examples:
      reflexarc sim
      reflexarc sim --world crossing --seed 7 --policy runs/reflex-0/policy.onnx
      reflexarc sim --lockstep --steps 500
      reflexarc sim --faults seed:17
      reflexarc sim --world crossing --robots 4
      reflexarc sim --policy racer.onnx --max-speed-mps 30
      reflexarc sim --no-auto-arm
      reflexarc sim --hold-to-run
      reflexarc sim --arm-each-runtime
    """

    world: str = "reference-1"
    """Which world: a name out of `reflexarc worlds`, or a file."""
    seed: int = 0
    """Which of the world's endless variants."""
    policy: Path | None = None
    """Build the eye from this policy; by default, ask the runtime on the bus."""
    rate: float | None = None
    """Steps a second; the contract's rate by default."""
    lockstep: bool = False
    """Wait for the command of every retina; time is the number of the step."""
    steps: int | None = None
    """End after so many steps; by default, at Ctrl-C."""
    faults: str | None = None
    """Harm the retinas on their way: a fault script (TOML), or seed:N for a random one."""
    robots: int = 1
    """So many robots in one world, robot0, robot1, …; each waits for a runtime of its own. They do
    not see each other."""
    check: bool = False
    """Let the body look for itself, along its own rays, whether a commanded way is free; it then
    goes slower, or stands, whatever the runtime says."""
    allow_body: bool = False
    """Let a policy drive that learned with a smaller, quicker or prompter body than the world's."""
    auto_arm: bool = True
    """Obey from the start, and again after a reset; else only after `reflexarc arm`."""
    hold_to_run: bool = False
    """Obey only while somebody holds a button: `reflexarc arm --hold`."""
    arm_each_runtime: bool = False
    """Let an arm count for one runtime: one that is started again must be armed again."""
    state: Path = Path("runs")
    """Folder in which a stop is kept until its reset; not used in lockstep."""
    bounds: Bounds = field(default_factory=Bounds)
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Drive until the end, then print the journey."""
        self._check_flags()
        _ = self._drawn_world  # a world that is none is said before anyone is waited for
        script = self._script()
        with StopFlag() as stop:
            journeys = drive_together(
                self.joining.fleet(self.robots),
                lambda robot, number, must_stop: self._ride(robot, number, must_stop, script),
                stop,
            )
        self._tell(journeys)
        return 0

    @cached_property
    def _world_text(self) -> str:
        """The file of the world, read once: what is told of it is what is driven in."""
        from reflexarc_sim_bridge.worlds.files import world_text

        return world_text(self.world)

    @cached_property
    def _drawn_world(self) -> "World":
        from reflexarc_sim_bridge.worlds.files import parse_world

        return parse_world(self._world_text, self.world).drawn(self.seed)

    def _ride(
        self,
        robot: Joining,
        number: int,
        stop: Callable[[], bool],
        script: "FaultScript | None",
    ) -> "Journey | None":
        """Drive one robot; None if it was stopped before it met a runtime."""
        from reflexarc_runtime.messages.topics import BODY_NODE

        # The first robot listens for the others.
        who = self._who(robot.robot)
        with robot.bus_in_time(
            BODY_NODE, stop, who, listens=number == 0, lockstep=self.lockstep
        ) as bus:
            if self.policy is not None:
                from reflexarc_runtime.policy.policy import load_contract

                body = self._body(load_contract(self.policy, bounds=self.bounds), number)
                return self._drive(bus, body, stop, script, robot.robot)
            asking = asking_of(bus, who, self.bounds, lambda c: self._body(c, number))
            wanted = first_wanted(asking, stop, who)
            if wanted is None:
                return None
            body = self._body(wanted.contract, number)
            with self._following(asking, wanted, number) as following:
                return self._drive(bus, body, stop, script, robot.robot, following)

    def _body(self, contract: "PolicyContract", number: int) -> "Body":
        """The robot that a contract describes, at its place at the start."""
        from reflexarc_sim_bridge.body.body import Body

        check_body(contract.body, self._drawn_world.body, allow=self.allow_body)
        rate_hz = self.rate or contract.rate_hz
        if self.lockstep and contract.hold_s and rate_hz != contract.rate_hz:
            raise UsageError(
                f"--rate: the policy holds actions for {contract.hold_s:g} s, which lockstep "
                f"counts at its own {contract.rate_hz:g} Hz; leave --rate out"
            )
        return Body(
            self._drawn_world,
            contract,
            rate_hz,
            self.seed,
            number,
            world_text=self._world_text,
            checks=self.check,
        )

    def _following(
        self, asking: "Asking", wanted: "Wanted", number: int
    ) -> "AbstractContextManager[Following | None]":
        """What builds the body anew for another runtime; in lockstep one drive has one runtime."""
        from reflexarc_sim_bridge.body.following import Following

        if self.lockstep:
            return nullcontext()
        return Following(
            asking.of,
            lambda contract: self._body(contract, number),
            wanted.contract,
            wanted.sender,
            asking.say,
        )

    def _who(self, robot: str) -> str:
        """The beginning of a robot's notices; the only robot needs no name."""
        return f"reflexarc sim: {robot}" if self.robots > 1 else "reflexarc sim"

    def _check_flags(self) -> None:
        if self.rate is not None and not MIN_RATE_HZ <= self.rate <= MAX_RATE_HZ:
            raise UsageError(
                f"--rate: expected {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g} Hz, got {self.rate}"
            )
        if self.steps is not None and self.steps < 1:
            raise UsageError(f"--steps: expected 1 or more, got {self.steps}")
        if not 1 <= self.robots <= MAX_ROBOTS:
            raise UsageError(f"--robots: expected 1 to {MAX_ROBOTS}, got {self.robots}")
        if not 0 <= self.seed < 1 << 64:
            raise UsageError(f"--seed: expected 0 to 2^64 − 1, got {self.seed}")

        if self.hold_to_run and self.lockstep:
            raise UsageError("--hold-to-run: not with --lockstep, in which no time passes")

    def _script(self) -> "FaultScript | None":
        from reflexarc_sim_bridge.body.faults.random_script import script_named

        if self.faults is None:
            return None
        if self.lockstep:
            raise UsageError(
                "--faults: not with --lockstep, which waits for the command of every retina"
            )
        return script_named(self.faults)

    def _drive(
        self,
        bus: "Bus",
        body: "Body",
        stop: Callable[[], bool],
        script: "FaultScript | None",
        robot: str,
        following: "Following | None" = None,
    ) -> "Journey":
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.loop.inbox import Inbox
        from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
        from reflexarc_sim_bridge.body.bridge import Bridge, faulty_retinas, gate_settings

        rate_hz = self.rate or body.contract.rate_hz
        inbox, clock = Inbox(), MonotonicClock()
        with faulty_retinas(bus, script, clock.now_ns) if script else nullcontext() as retinas:
            settings = gate_settings(
                body,
                auto_arm=self.auto_arm and not (self.hold_to_run or self.arm_each_runtime),
                hold_to_run=self.hold_to_run,
                arm_each_runtime=self.arm_each_runtime,
                lockstep=self.lockstep,
            )
            latch = self._latch(robot)
            bridge = Bridge(bus, body, robot, inbox, settings, retinas, latch, following)
            line = f"{self._who(robot)}: {self.world}, seed {self.seed}, {rate_hz:g} Hz"
            aside.print(line, soft_wrap=True)
            with waiting_for_commands(bus, self._who(robot), lambda: bridge.has_heard):
                if self.lockstep:
                    return bridge.drive_in_lockstep(round(1e9 / rate_hz), stop, self.steps)
                return bridge.drive(RatePacer(rate_hz, clock, inbox), stop, self.steps)

    def _latch(self, robot: str) -> "StopLatch | None":
        """The stop that outlives the body; in lockstep the same run shall give the same drive."""
        from reflexarc_sim_bridge.body.latch import StopLatch

        if self.lockstep:
            return None
        latch = StopLatch(self.state, robot)
        if latch.stopped:
            aside.print(
                f"{self._who(robot)}: stopped ({plain(latch.stopped)}) until `reflexarc reset`",
                soft_wrap=True,
            )
        return latch

    def _tell(self, journeys: "dict[str, Journey]") -> None:
        """Print the journey of one robot, or those of several by name."""
        if self.json and journeys:
            plain = {robot: asdict(journey) for robot, journey in journeys.items()}
            print_json(plain if self.robots > 1 else next(iter(plain.values())))
            return
        for robot, journey in journeys.items():
            said = {
                "steps": journey.steps,
                "distance": f"{journey.distance_m:.1f} m",
                "contacts": journey.contacts,
            }
            console.print(facts({"robot": robot, **said} if self.robots > 1 else said))
