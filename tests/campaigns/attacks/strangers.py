"""A stranger's commands to a body that nobody drives."""

import time
from collections.abc import Iterator

from campaigns.attacks.lies import LIES, Lie, Spoken, anonymous, command
from campaigns.attacks.outcome import Outcome, counts, held_if, known_if
from campaigns.attacks.stage import Scene, Stage
from reflexarc_runtime.bus import Bus, Publisher
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import COMMAND, Quality
from support.witness import FOR_EVER, Witness

WATCHED_S = 10.0
EACH_S = 0.3
TIMES = 101
"""On a busy machine the bus drops many; a tenth must have been refused, by name."""
NOT_REFUSED = ("on the key of another robot", "safe, with a speed of 5 m/s")
"""The body does not hear the first; it stands by the second, whose speeds do not count."""


def once_and_gone(stage: Stage) -> Iterator[Outcome]:
    """One anonymous command, for ever; the stranger is there, and gone."""
    with stage.standing() as scene:
        with Bus(BusConfig("robot0", scene.port), time.monotonic_ns) as stranger:
            other = Witness(stranger)
            publisher = other.publisher(COMMAND)
            put(scene, publisher, lambda _: Spoken(anonymous(), b""))
            time.sleep(WATCHED_S / 2)
        time.sleep(WATCHED_S / 2)
        yield Outcome(
            "an anonymous command, for ever",
            f"once; {WATCHED_S / 2:g} s with the stranger, {WATCHED_S / 2:g} s after it left",
            scene.seen.way_m,
            counts(scene.seen.refused),
            held_if(scene.seen.way_m == 0.0),
        )


def in_every_respect(stage: Stage) -> Iterator[Outcome]:
    """Every lie of the list, once each and then 100 times in 0.2 s."""
    with stage.standing() as scene:
        publisher = scene.seen.publisher(COMMAND)
        for name, lie in LIES.items():
            before, begun_m = scene.seen.refused, scene.seen.way_m
            put(scene, publisher, lie)
            time.sleep(EACH_S)
            for _ in range(TIMES - 1):
                put(scene, publisher, lie)
                time.sleep(0.002)
            settle(scene.seen)
            rolled_m = scene.seen.way_m - begun_m
            refused = sum(scene.seen.refused.values()) - sum(before.values())
            yield Outcome(
                f"a command, {name}",
                "once, then 100 times in 0.2 s",
                rolled_m,
                counts(scene.seen.refused, before),
                held_if(rolled_m == 0.0 and (name in NOT_REFUSED or refused > TIMES / 10)),
            )


def in_order(stage: Stage) -> Iterator[Outcome]:
    """A stranger who does all that a runtime does is one: nothing tells them apart."""
    with stage.standing() as scene:
        publisher, begun_m = scene.seen.publisher(COMMAND), scene.seen.way_m
        for _ in range(100):
            put(scene, publisher, lambda stamp: Spoken(command(stamp)))
            time.sleep(0.01)
        spoken_m = scene.seen.way_m - begun_m
        time.sleep(0.2)
        silent_m = scene.seen.way_m
        time.sleep(1.0)
        stood = scene.seen.way_m == silent_m
        yield Outcome(
            "a command in order in every respect",
            "100 a second, for 1 s, by a stranger who reads the body's identifier off the bus",
            spoken_m,
            f"the stranger holds the lease, epoch {scene.seen.lease.epoch}; "
            f"{'stands' if stood else 'drives on'} after it falls silent",
            known_if(spoken_m > 0.0) if stood else held_if(False),
        )
        before, begun_m = scene.seen.refused, scene.seen.way_m
        begin_s = time.monotonic()
        endless = {"linear_mps": 1e308, "lateral_mps": -1e308}
        for _ in range(100):
            put(scene, publisher, lambda stamp: Spoken(command(stamp, **endless)))
            time.sleep(0.01)
        spoken_s = time.monotonic() - begin_s
        settle(scene.seen)
        rolled_m = scene.seen.way_m - begun_m
        # No faster than the fastest action, 1 m/s in each direction, until the lease ends.
        yield Outcome(
            "a command in order, of 10³⁰⁸ m/s",
            "100 a second, for 1 s",
            rolled_m,
            counts(scene.seen.refused, before),
            known_if(rolled_m > 0.0) if rolled_m < (spoken_s + 0.2) * 2**0.5 else held_if(False),
        )
        begun_m = scene.seen.way_m
        kept = Spoken(command(scene.seen.stamp, **FOR_EVER))
        put(scene, publisher, lambda _: kept)
        time.sleep(WATCHED_S)
        rolled_m = scene.seen.way_m - begun_m
        # Until the lease ends: 100 ms of silence at 1 m/s at most, and two steps of the body.
        yield Outcome(
            "a command that repeats the body's identifier, of time 0, for ever",
            f"once, {WATCHED_S:g} s",
            rolled_m,
            f"the lease ends by silence: epoch {scene.seen.lease.epoch}, {scene.seen.lease.state}",
            held_if(rolled_m < 0.2),
        )


def put(scene: Scene, publisher: Publisher, lie: Lie) -> None:
    """Say a lie, made from the body's last retina."""
    spoken = lie(scene.seen.stamp)
    if spoken.robot != "robot0":
        key = COMMAND.key(spoken.robot)
        publisher = scene.seen.bus.publisher_of_key(key, spoken.encoding, Quality.CONTROL)
    publisher.put_raw(spoken.payload, spoken.attachment, spoken.encoding)


def settle(seen: Witness) -> None:
    """The body says once a second what it refused."""
    heard = len(seen.leases)
    seen.wait_for(lambda _: len(seen.leases) > heard + 1, "what the body refused")


ATTACKS = (once_and_gone, in_every_respect, in_order)
