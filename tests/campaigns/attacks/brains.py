"""Two runtimes for one robot, and two bodies of one name."""

import time
from collections.abc import Iterator
from itertools import pairwise

from campaigns.attacks.outcome import Outcome, counts, held_if
from campaigns.attacks.stage import Scene, Stage
from campaigns.attacks.strangers import settle
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.topics import RETINA, STATUS
from reflexarc_runtime.messages.wire import (
    Message,
    unpack_stamp,
)
from reflexarc_runtime.messages_pb2 import Status
from support.processes import Process, started, wait_until
from support.witness import Witness, body, joined

WATCHED_S = 3.0
SILENCE_S = PolicyContract().max_input_age_s
OTHER_HOLDER = "another one holds the lease"


def two_runtimes(stage: Stage) -> Iterator[Outcome]:
    """The second one is not obeyed; after the death of the first it is, and after a release."""
    with stage.driving() as scene, scene.runtime():
        seen, holder = scene.seen, scene.seen.lease.holder
        seen.wait_for(lambda lease: lease.refused[OTHER_HOLDER] > 0, "two runtimes")
        settle(seen)
        before, sent, epoch = seen.refused, dict(seen.commands), seen.lease.epoch
        time.sleep(WATCHED_S)
        settle(seen)
        refused = seen.refused[OTHER_HOLDER] - before[OTHER_HOLDER]
        by_first = seen.commands[holder] - sent[holder]
        by_second = sum(seen.commands.values()) - sum(sent.values()) - by_first
        yield Outcome(
            "two runtimes for one robot",
            f"{by_first} commands of the first, {by_second} of the second",
            0.0,
            f"{refused} × {OTHER_HOLDER}; epoch {seen.lease.epoch}, of the first",
            held_if(refused > 0.9 * by_second and (holder, epoch) == _lease(scene)),
        )
        scene.loop.kill()
        begin_s = time.monotonic()
        seen.wait_for(lambda lease: lease.epoch > epoch and bool(lease.holder), "a hand-over")
        yield Outcome(
            "the first of two runtimes is killed",
            "SIGKILL",
            0.0,
            f"the second one drives within {time.monotonic() - begin_s:.1f} s, "
            f"epoch {seen.lease.epoch}",
            held_if(seen.lease.holder != holder and seen.rolled_m() > 0.3),
        )


def two_bodies(stage: Stage) -> Iterator[Outcome]:
    """A second body of the same name: the runtime trusts neither."""
    with stage.driving() as scene:
        words = ("--zenoh", joined(scene.port, scene.folder), *stage.empty_world())
        with body(stage.policy, scene.port, scene.folder, *words) as second:
            tried = "both send 50 retinas a second"
            yield _stands_beside(scene, "two bodies of one name", tried, second)


def a_log_played(stage: Stage) -> Iterator[Outcome]:
    """`reflexarc play` of a drive, onto the robot that it was recorded of."""
    with stage.driving("--record", "drive.mcap") as scene:
        time.sleep(3.0)
        scene.loop.terminate()
        scene.loop.wait()
        log, zenoh = scene.folder / "drive.mcap", joined(scene.port, scene.folder)
        with scene.runtime():
            scene.seen.wait_for(lambda lease: lease.state == "driving", "a drive")
            with started("play", log, "--zenoh", zenoh, "--loop", "--json") as player:
                tried = "a drive of 3 s, in a loop"
                yield _stands_beside(scene, "`play` onto a live robot", tried, player)


def _stands_beside(scene: Scene, attack: str, tried: str, other: Process) -> Outcome:
    """How far a robot rolls from the moment at which another source is heard."""
    seen, verdicts = scene.seen, verdicts_of(scene)
    wait_until(lambda: is_told(seen, pb.TWO_SOURCES), "two sources", 60.0)
    silences = _Silences(scene)
    begun_m = seen.way_m
    time.sleep(0.3)
    stood_m = seen.way_m
    time.sleep(WATCHED_S)
    stands = seen.way_m == stood_m
    assert other.poll() is None, "the other one has ended"
    # Whoever is silent for 100 ms, as on a busy machine, is no second source for that long.
    longest_s = silences.longest_s()
    how = "stands" if stands else f"drives in a silence of {longest_s * 1e3:.0f} ms"
    return Outcome(
        attack,
        tried,
        seen.way_m - begun_m,
        f"{most(verdicts)}; {how}; {WATCHED_S:g} s",
        held_if((stands or longest_s > SILENCE_S) and stood_m - begun_m < 0.3),
    )


class _Silences:
    """How long each who shows retinas is silent at most, from now on."""

    def __init__(self, scene: Scene) -> None:
        self._heard_s: dict[bytes, list[float]] = {}
        scene.seen.bus.subscribe([RETINA], self._hear)

    def _hear(self, message: Message) -> None:
        sender = unpack_stamp(message.attachment).sender
        self._heard_s.setdefault(sender, []).append(message.received_ns / 1e9)

    def longest_s(self) -> float:
        """The longest time between two retinas of one of them."""
        gaps = [b - a for times in self._heard_s.values() for a, b in pairwise(times)]
        return max(gaps, default=0.0)


def is_told(seen: Witness, verdict: int) -> bool:
    """Whether the last command has this verdict."""
    return seen.last_command is not None and seen.last_command.verdict == verdict


def verdicts_of(scene: Scene) -> list[Status]:
    """What the runtime's status says from now on."""
    heard: list[Status] = []

    def hear(message: object) -> None:
        status = Status.FromString(message.payload)  # type: ignore[attr-defined]
        if status.node == "runtime":
            heard.append(status)

    scene.seen.bus.subscribe([STATUS], hear)
    return heard


def most(statuses: list[Status]) -> str:
    """The verdicts of the last second."""
    return "verdicts " + counts(dict(statuses[-1].verdicts)) if statuses else "no status"


def _lease(scene: Scene) -> tuple[bytes, int]:
    return scene.seen.lease.holder, scene.seen.lease.epoch


ATTACKS = (two_runtimes, two_bodies, a_log_played)
