"""The same lies to a robot that speaks ROS 2: does `reflexarc ros2` make twists of them?"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from campaigns.attacks.lies import LIES, Lie, Spoken, anonymous, command
from campaigns.attacks.outcome import Outcome, counts, held_if, known_if
from campaigns.attacks.stage import Stage
from reflexarc_runtime.bus import Bus, Publisher
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import COMMAND, SCAN, Quality
from reflexarc_runtime.messages.wire import Message, Stamp, protobuf_encoding, unpack_stamp
from support.processes import Process, finished, started, wait_until
from support.ros2_base import HOLDS_FOR_EVER, rolled
from support.ros2_drives import stands
from support.ros2_robot import Robot, robot

LIMITS = ("--max-linear", 0.5, "--max-lateral", 0, "--max-angular", 1)
PERIOD_S = 0.02


@dataclass
class Bridged:
    """A robot that stands, its bridge, and a stranger."""

    body: Robot
    bridge: Process
    publisher: Publisher
    stamps: list[Stamp]

    def put(self, lie: Lie) -> None:
        """Say a lie."""
        spoken = lie(self.stamps[-1])
        self.publisher.put_raw(spoken.payload, spoken.attachment, spoken.encoding)

    def twists_of(self, say: Callable[[], None]) -> tuple[int, int, float, float]:
        """Of what was said: twists, those that are not zero, the fastest, and metres rolled."""
        begun, begun_ns = len(self.body.told), time.time_ns()
        say()
        told = self.body.told[begun:]
        moving = [word for word in told if not word.is_standstill]
        fastest_mps = max((abs(word.ahead_mps) for word in told), default=0.0)
        roll = rolled(HOLDS_FOR_EVER, self.body.told, begun_ns, time.time_ns())
        return len(told), len(moving), fastest_mps, roll.distance_m


def a_command_for_ever(stage: Stage) -> Iterator[Outcome]:
    """An armed bridge, and an anonymous command of 100 m/s; then every other lie."""
    with bridged(stage) as scene:
        fast = {"linear_mps": 100.0}

        def once() -> None:
            scene.put(lambda _: Spoken(anonymous(), b""))
            time.sleep(9.0)

        yield _row(scene, "`ros2`: an anonymous command, for ever", "once, 9 s", once)

        def every() -> None:
            for name, lie in LIES.items():
                for _ in range(20 if "another robot" not in name else 0):
                    scene.put(lie)
                    time.sleep(0.005)

        tried = f"{len(LIES) - 1} lies, 20 times each, 200 a second"
        yield _row(scene, "`ros2`: every other lie of the list above", tried, every)

        def in_order() -> None:
            for _ in range(100):
                scene.put(lambda stamp: Spoken(command(stamp, **fast)))
                time.sleep(0.01)
            time.sleep(1.5)

        tried = "100 a second, for 1 s, of 100 m/s; a base that brakes with 2 m/s²"
        yield _row(
            scene, "`ros2`: a command in order in every respect", tried, in_order, known=True
        )
        report = finished(scene.bridge, 2)
        yield Outcome(
            "`ros2`: at its end",
            "SIGINT",
            None,
            f"{report['commands']} commands heard; {counts(report['refused_commands'])}",
            held_if(stands(scene.body.told[-10:] * 3)),
        )


def _row(
    scene: Bridged, attack: str, tried: str, say: Callable[[], None], known: bool = False
) -> Outcome:
    twists, moving, fastest_mps, distance_m = scene.twists_of(say)
    if known and fastest_mps <= 0.5 and stands(scene.body.told):
        held = known_if(moving > 0)
    else:
        held = held_if(moving == 0 and twists > 0)
    said = f"{moving} of {twists} twists not zero, the fastest {fastest_mps:g} m/s"
    return Outcome(attack, tried, distance_m, said, held)


@contextmanager
def bridged(stage: Stage) -> Iterator[Bridged]:
    """A robot that stands, and its armed bridge."""
    port, folder = stage.place()
    words: tuple[Any, ...] = ("--json", "--port", port, "--auto-arm", *LIMITS)
    stamps: list[Stamp] = []

    def see(message: Message) -> None:
        stamps.append(unpack_stamp(message.attachment))

    with (
        robot(port, "scan", "cmd_vel", stamped=False) as body,
        started("ros2", *words, cwd=folder) as bridge,
        Bus(BusConfig(port=port), time.monotonic_ns) as bus,
    ):
        wait_until(lambda: stands(body.told), "the bridge speaks")
        bus.subscribe([SCAN], see)
        encoding = protobuf_encoding(COMMAND.schema)
        key = COMMAND.key("robot0")
        publisher = bus.publisher_of_key(key, encoding, Quality.CONTROL)
        wait_until(lambda: publisher.has_listener and stamps, "the bridge listens")
        yield Bridged(body, bridge, publisher, stamps)


ATTACKS = (a_command_for_ever,)
