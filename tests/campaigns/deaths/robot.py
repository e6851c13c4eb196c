"""One robot: a simulated body that lives on, and a service that dies again and again."""

import os
import random
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from campaigns.deaths.kinds import WAYS, Death, Way
from campaigns.deaths.leftovers import leftovers
from campaigns.deaths.services import Service
from campaigns.deaths.witness import Holder, Witness
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus, Publisher
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import ARM, LEASE, POSE
from support.processes import started
from support.service_life import Life

PATIENCE_S = 240.0
MOST_DRIVEN_S = 1.0
MOST_STARTING_S = 0.5
STOOD_S = 0.2
"""How long the body is watched after each return before anybody arms it."""
STILL_M = 1e-9


@dataclass
class Robot:
    """Dies as often as it is told to."""

    folder: Path
    port: int
    seed: int
    service: Service
    deaths: list[Death] = field(default_factory=list)
    unprovoked: list[str] = field(default_factory=list)
    """Ends of a service that nobody had struck."""
    witness: Witness = field(default_factory=Witness)

    def die(self, deaths: int, told: Callable[[Death], None]) -> None:
        """All deaths, one after another; the last life is asked to end."""
        rng = random.Random(self.seed)
        policy = self.folder / "policy.onnx"
        words = ("sim", "--port", self.port, "--arm-each-runtime", "--policy", policy)
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
        joins = BusConfig(port=self.port)
        with started(*words, cwd=self.folder), Bus(joins, time.monotonic_ns) as bus:
            bus.subscribe([LEASE, POSE], self.witness.hear)
            publisher = bus.publisher(ARM)
            with self.service:
                self._until(lambda: self._is_ready() and self.witness.holders, "the first runtime")
                for number in range(deaths):
                    way = rng.choice(WAYS)
                    longest_s = MOST_STARTING_S if way.at_start else MOST_DRIVEN_S
                    death = Death(number, way.name, rng.uniform(0.0, longest_s))
                    self.deaths.append(death)
                    try:
                        self._die(death, way, publisher)
                    except TimeoutError as error:
                        death.failures.append(str(error))
                        break
                    told(death)
        self._judge_end()

    def _die(self, death: Death, way: Way, publisher: Publisher) -> None:
        lives = self.service.lives
        life = self._starting() if way.at_start else self._driving(publisher)
        time.sleep(death.after_s)
        struck_s, known = time.monotonic(), len(lives)
        os.kill(life.pid, way.number)
        self._until(lambda: life.ended_s is not None, "the end of the process that was struck")
        self._until(lambda: len(lives) > known, "another start")
        began_s, ended_s = lives[known].began_s, life.ended_s or 0.0
        since = partial(self._holder_since, began_s)
        self._until(lambda: since() is not None, "a runtime that holds the body")
        self._until(self._is_ready, "a runtime that is ready")
        holder = since()
        assert holder is not None
        death.again_s, death.ended_s = holder.since_s - struck_s, ended_s - struck_s
        death.started_s = (lives[-1].ready_s or 0.0) - ended_s
        death.status, death.cause = life.status, life.cause
        self._judge(death, was_armed=holder.armed, starts=len(lives) - known)

    def _driving(self, publisher: Publisher) -> Life:
        """A life whose robot drives."""
        self._arm(publisher)
        return self.service.lives[-1]

    def _starting(self) -> Life:
        """A life that has just begun, as the one before it was killed."""
        lives = self.service.lives
        life, known = lives[-1], len(lives)
        os.kill(life.pid, signal.SIGKILL)
        self._until(lambda: len(lives) > known, "the next runtime")
        return lives[-1]

    def _judge(self, death: Death, *, was_armed: bool, starts: int) -> None:
        time.sleep(STOOD_S)
        since_s, until_s = self.witness.holders[-1].since_s, time.monotonic()
        if was_armed or self.witness.armed:
            death.failures.append("armed for a runtime that nobody armed it for")
        rolled_m = self.witness.rolled_m(since_s, until_s)
        if rolled_m > STILL_M:
            death.failures.append(f"rolled {rolled_m:.3f} m before it was armed")
        if starts != 1:
            more = [f"{life.cause} {life.status}" for life in self.service.lives[-starts:-1]]
            self.unprovoked.append(f"after death {death.number}: {', '.join(more)}")
        death.failures += leftovers(self.service.lives[:-1])

    def _arm(self, publisher: Publisher) -> None:
        """Say it until the body has done it: whom it obeys may change meanwhile."""

        def drives() -> bool:
            publisher.put(pb.Arm(reason="campaign").SerializeToString(), time.monotonic_ns())
            time.sleep(0.05)
            return self.witness.armed and self.witness.state == "driving"

        self._until(drives, "a body that drives")

    def _holder_since(self, began_s: float) -> Holder | None:
        """The first runtime that the body obeyed after that."""
        return next((one for one in self.witness.holders if one.since_s > began_s), None)

    def _is_ready(self) -> bool:
        lives = self.service.lives
        return bool(lives) and lives[-1].ready_s is not None

    def _judge_end(self) -> None:
        """The last life was asked to end: cleanly, and with a finished log."""
        last = self.service.lives[-1]
        failures = leftovers(self.service.lives)
        if (last.cause, last.status) != ("stop", 0):
            failures.append(f"asked to end, it ended so: {last.cause} {last.status}")
        self.deaths[-1].failures += failures

    def _until(self, holds: Callable[[], object], what: str) -> None:
        """Wait; raises `TimeoutError` with what was waited for."""
        end_s = time.monotonic() + PATIENCE_S
        while not holds():
            if time.monotonic() > end_s or self.service.gave_up:
                raise TimeoutError(f"waited in vain for {what}: {self.service.lives[-1]}")
            time.sleep(0.002)
