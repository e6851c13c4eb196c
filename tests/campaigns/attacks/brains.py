"""Two runtimes for one robot, two bodies of one name, and strangers who pretend to be a body."""

import time
from collections.abc import Iterator

import numpy as np

from campaigns.attacks.outcome import Outcome, counts, held_if, known_if
from campaigns.attacks.stage import Scene, Stage
from campaigns.attacks.strangers import settle
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import RETINA, STATUS
from reflexarc_runtime.messages.wire import MAX_SEQUENCE, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Status
from support.plain_body import plain_body
from support.processes import Process, started, wait_until
from support.witness import Witness, body, joined, runtime

WATCHED_S = 3.0
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


def a_stranger_shows_retinas(stage: Stage) -> Iterator[Outcome]:
    """Retinas beside the true body's, under an identifier of its own, and under the body's."""
    for own in (True, False):
        with stage.driving() as scene:
            sender = None if own else scene.seen.body
            with Bus(BusConfig("robot0", scene.port), time.monotonic_ns, sender) as stranger:
                if own:
                    yield _shown_beside(scene, stranger)
                else:
                    yield _shown_as_the_body(scene, stranger)


def a_retina_of_a_time_to_come(stage: Stage) -> Iterator[Outcome]:
    """One retina under the body's identifier, newer than all that the body will ever send."""
    with stage.driving() as scene:
        seen, verdicts = scene.seen, _verdicts(scene)
        with Bus(BusConfig("robot0", scene.port), time.monotonic_ns, seen.body) as stranger:
            forged = Stamp(MAX_SEQUENCE, 2**62, seen.body)
            _Retinas(stranger).forge(forged)
            wait_until(lambda: _is_told(seen, pb.STALE_INPUT), "a pause", 10.0)
            begin_s, begun_m = time.monotonic(), seen.way_m
            wait_until(lambda: _is_told(seen, pb.OK), "a drive", 10.0)
            pause_s, rolled_m = time.monotonic() - begin_s, seen.way_m - begun_m
            time.sleep(1.0)
    yield Outcome(
        "one retina under the body's identifier, of the year 2116",
        "sequence 2³² − 1, time 2⁶² ns",
        rolled_m,
        f"a pause of {pause_s:.1f} s at most, then on; {_most(verdicts)}; {counts(seen.refused)}",
        held_if(rolled_m < 0.3),
    )


def a_lone_stranger(stage: Stage) -> Iterator[Outcome]:
    """To a runtime, whoever sends proper retinas is a body; nothing that moves obeys its echo."""
    port, folder = stage.place()
    with plain_body(PolicyContract(), port) as shown, runtime(stage.policy, port, folder):
        wait_until(lambda: shown.verdicts.count("OK") > 50, "a runtime that drives")
        echoes = {command.body for _, command in shown.heard if command.body}
        yield Outcome(
            "proper retinas of a stranger, without a body",
            "50 a second",
            None,
            "verdict OK: to a runtime it is a body. All commands name the stranger: "
            f"{len(echoes)} identifier, which no other body obeys",
            held_if(len(echoes) == 1),
        )


def _stands_beside(scene: Scene, attack: str, tried: str, other: Process) -> Outcome:
    """How far a robot rolls from the moment at which another source is heard."""
    seen, verdicts = scene.seen, _verdicts(scene)
    wait_until(lambda: _is_told(seen, pb.TWO_SOURCES), "two sources", 60.0)
    begun_m = seen.way_m
    time.sleep(0.3)
    stood_m = seen.way_m
    time.sleep(WATCHED_S)
    stands = seen.way_m == stood_m
    assert other.poll() is None, "the other one has ended"
    return Outcome(
        attack,
        tried,
        seen.way_m - begun_m,
        f"{_most(verdicts)}; {'stands' if stands else 'does not stand'} for {WATCHED_S:g} s",
        held_if(stands and stood_m - begun_m < 0.3),
    )


def _is_told(seen: Witness, verdict: int) -> bool:
    return seen.last_command is not None and seen.last_command.verdict == verdict


def _shown_beside(scene: Scene, stranger: Bus) -> Outcome:
    flood = _Retinas(stranger)
    flood.show(50)
    begun_m, verdicts = scene.seen.way_m, _verdicts(scene)
    flood.show(round(50 * WATCHED_S))
    rolled_m = scene.seen.way_m - begun_m
    return Outcome(
        "a stranger's retinas beside the body's",
        "50 a second, bright",
        rolled_m,
        _most(verdicts),
        held_if(rolled_m < 0.1),
    )


def _shown_as_the_body(scene: Scene, stranger: Bus) -> Outcome:
    flood, begun_m, verdicts = _Retinas(stranger), scene.seen.way_m, _verdicts(scene)
    flood.show(round(50 * WATCHED_S))
    rolled_m = scene.seen.way_m - begun_m
    return Outcome(
        "the same with the body's own identifier",
        "50 a second, bright",
        rolled_m,
        f"{_most(verdicts)}; the robot is driven by what the stranger shows",
        known_if(rolled_m > 0.0),
    )


class _Retinas:
    """Shows bright retinas."""

    def __init__(self, bus: Bus) -> None:
        self._publisher = bus.publisher(RETINA)
        wait_until(lambda: self._publisher.has_listener, "a listener")

    def forge(self, stamp: Stamp) -> None:
        """One, whose attachment says what it likes."""
        spec = PolicyContract().retina
        payload = encode_retina(np.zeros(spec.shape, np.uint8), spec, stamp.time_ns, "robot0")
        self._publisher.put_raw(payload, pack_stamp(stamp), protobuf_encoding(RETINA.schema))

    def show(self, count: int) -> None:
        spec = PolicyContract().retina
        for _ in range(count):
            now_ns = time.monotonic_ns()
            bright = np.full(spec.shape, 200, np.uint8)
            self._publisher.put(encode_retina(bright, spec, now_ns, "robot0"), now_ns)
            time.sleep(0.02)


def _verdicts(scene: Scene) -> list[Status]:
    """What the runtime's status says from now on."""
    heard: list[Status] = []

    def hear(message: object) -> None:
        status = Status.FromString(message.payload)  # type: ignore[attr-defined]
        if status.node == "runtime":
            heard.append(status)

    scene.seen.bus.subscribe([STATUS], hear)
    return heard


def _most(statuses: list[Status]) -> str:
    """The verdicts of the last second."""
    return "verdicts " + counts(dict(statuses[-1].verdicts)) if statuses else "no status"


def _lease(scene: Scene) -> tuple[bytes, int]:
    return scene.seen.lease.holder, scene.seen.lease.epoch


ATTACKS = (
    two_runtimes,
    two_bodies,
    a_log_played,
    a_stranger_shows_retinas,
    a_retina_of_a_time_to_come,
    a_lone_stranger,
)
