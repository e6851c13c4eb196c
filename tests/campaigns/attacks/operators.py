"""Stops, resets and arms of strangers, and answers that no body gave."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from campaigns.attacks.outcome import Outcome, held_if, known_if, last_line
from campaigns.attacks.stage import Scene, Stage
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import ARM, BODY, LEASE, RELEASE, RESET, STOP, Topic
from support.processes import reflexarc

FLOOD_S = 2.0


def floods(stage: Stage) -> Iterator[Outcome]:
    """1,000 messages a second of what everybody may say: nothing moves by it that must not."""
    with stage.driving() as scene:
        with flooding(scene, (RELEASE, b"")) as sent:
            time.sleep(FLOOD_S)
        scene.seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        yield Outcome(
            "a flood of releases",
            f"{sent[0]} in {FLOOD_S:g} s",
            scene.seen.back_m,
            f"epoch {scene.seen.lease.epoch}; the runtime drives again after it",
            held_if(scene.seen.back_m == 0.0),
        )
        with flooding(scene, (STOP, b"\xff")) as sent:
            scene.seen.wait_for(lambda lease: bool(lease.stopped), "a stop")
            begun_m = scene.seen.way_m
            time.sleep(FLOOD_S)
        rolled_m = scene.seen.way_m - begun_m
        done = reflexarc("reset", "--port", scene.port)
        yield Outcome(
            "a flood of stops, garbled",
            f"{sent[0]} in {FLOOD_S:g} s",
            rolled_m,
            f"{scene.seen.lease.state}; a reset after it: {last_line(done.stdout)}",
            held_if(rolled_m < 0.05 and done.returncode == 0),
        )


def storm(stage: Stage) -> Iterator[Outcome]:
    """Resets and arms of a stranger, while an operator says stop: anybody may say either."""
    with stage.driving() as scene:
        with flooding(scene, (RESET, b""), (ARM, b"")) as sent:
            done = reflexarc("stop", "--port", scene.port)
            begun_m = scene.seen.way_m
            time.sleep(FLOOD_S)
        time.sleep(FLOOD_S)
        rolled_m = scene.seen.way_m - begun_m
        yield Outcome(
            "a storm of resets and arms against `reflexarc stop`",
            f"{sent[0]} of each; {FLOOD_S:g} s during it, {FLOOD_S:g} s after it",
            rolled_m,
            f"exit status {done.returncode}: {last_line(done.stdout + done.stderr)}",
            known_if(rolled_m > 0.0),
        )


def a_forged_lease(stage: Stage) -> Iterator[Outcome]:
    """A stranger says that the body is stopped; an operator must not be told so too early."""
    lie = pb.Lease(armed=True, stopped="a lie", state="stopped: waiting for a reset", epoch=9)
    with stage.driving() as scene, forging(scene, (LEASE, lie.SerializeToString())) as sent:
        done = reflexarc("stop", "--port", scene.port)
        time.sleep(0.3)
        begun_m = scene.seen.way_m
        time.sleep(FLOOD_S)
        rolled_m = scene.seen.way_m - begun_m
        yield Outcome(
            "a forged lease that says stopped, beside `reflexarc stop`",
            f"{sent[0]}, 1,000 a second",
            rolled_m,
            f"exit status {done.returncode}; the body: {scene.seen.lease.state}",
            held_if(rolled_m == 0.0 and bool(scene.seen.lease.stopped)),
        )


def a_forged_lease_of_a_driver(stage: Stage) -> Iterator[Outcome]:
    """The other way round: a stranger says that the body drives, and the runtime has nothing."""
    lie = pb.Lease(holder=b"a stranger......", armed=True, state="driving", epoch=1 << 60)
    limits = pb.Body(world="none", limits=pb.BodyLimits(linear_mps=1e9))
    says = (LEASE, lie.SerializeToString()), (BODY, limits.SerializeToString())
    with stage.standing("--no-auto-arm") as scene, scene.runtime(), forging(scene, *says) as sent:
        time.sleep(1.0)
        begun_m = scene.seen.way_m
        time.sleep(FLOOD_S)
        rolled_m = scene.seen.way_m - begun_m
        yield Outcome(
            "a forged lease that says armed, and forged limits of 10⁹ m/s, of a disarmed body",
            f"{sent[0]}, 1,000 a second",
            rolled_m,
            f"the body: {scene.seen.lease.state}",
            held_if(rolled_m == 0.0),
        )


@contextmanager
def flooding(scene: Scene, *says: tuple[Topic, bytes]) -> Iterator[list[int]]:
    """What a stranger says whom the body hears, 1,000 times a second; and how often until now."""
    publishers = [(scene.seen.publisher(topic), payload) for topic, payload in says]
    with _repeated(lambda: [p.put(payload, 0) for p, payload in publishers]) as sent:
        yield sent


@contextmanager
def forging(scene: Scene, *says: tuple[Topic, bytes]) -> Iterator[list[int]]:
    """The same of what only a body says; nobody need hear it yet."""
    with Bus(BusConfig("robot0", scene.port), time.monotonic_ns) as bus:
        publishers = [(bus.publisher(topic), payload) for topic, payload in says]
        with _repeated(lambda: [p.put(payload, 0) for p, payload in publishers]) as sent:
            yield sent


@contextmanager
def _repeated(say: Callable[[], object]) -> Iterator[list[int]]:
    ended, sent = Event(), [0]

    def repeat() -> None:
        while not ended.wait(0.001):
            say()
            sent[0] += 1

    thread = Thread(target=repeat)
    thread.start()
    try:
        yield sent
    finally:
        ended.set()
        thread.join()


ATTACKS = (floods, storm, a_forged_lease, a_forged_lease_of_a_driver)
