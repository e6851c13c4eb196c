"""Retinas that no body saw: beside the true one's, in its name, of a time to come, and alone."""

import time
from collections.abc import Iterator

import numpy as np

from campaigns.attacks.brains import is_told, most, verdicts_of
from campaigns.attacks.outcome import Outcome, counts, held_if, known_if
from campaigns.attacks.stage import Scene, Stage
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import RETINA
from reflexarc_runtime.messages.wire import MAX_SEQUENCE, Stamp, pack_stamp, protobuf_encoding
from support.plain_body import plain_body
from support.processes import wait_until
from support.witness import runtime

WATCHED_S = 3.0


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
        seen, verdicts = scene.seen, verdicts_of(scene)
        with Bus(BusConfig("robot0", scene.port), time.monotonic_ns, seen.body) as stranger:
            forged = Stamp(MAX_SEQUENCE, 2**62, seen.body)
            _Retinas(stranger).forge(forged)
            wait_until(lambda: is_told(seen, pb.STALE_INPUT), "a pause", 10.0)
            begin_s, begun_m = time.monotonic(), seen.way_m
            wait_until(lambda: is_told(seen, pb.OK), "a drive", 10.0)
            pause_s, rolled_m = time.monotonic() - begin_s, seen.way_m - begun_m
            time.sleep(1.0)
    yield Outcome(
        "one retina under the body's identifier, of the year 2116",
        "sequence 2³² − 1, time 2⁶² ns",
        rolled_m,
        f"a pause of {pause_s:.1f} s at most, then on; {most(verdicts)}; {counts(seen.refused)}",
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


def _shown_beside(scene: Scene, stranger: Bus) -> Outcome:
    flood = _Retinas(stranger)
    flood.show(50)
    begun_m, verdicts = scene.seen.way_m, verdicts_of(scene)
    flood.show(round(50 * WATCHED_S))
    rolled_m = scene.seen.way_m - begun_m
    return Outcome(
        "a stranger's retinas beside the body's",
        "50 a second, bright",
        rolled_m,
        most(verdicts),
        held_if(rolled_m < 0.1),
    )


def _shown_as_the_body(scene: Scene, stranger: Bus) -> Outcome:
    flood, begun_m, verdicts = _Retinas(stranger), scene.seen.way_m, verdicts_of(scene)
    flood.show(round(50 * WATCHED_S))
    rolled_m = scene.seen.way_m - begun_m
    return Outcome(
        "the same with the body's own identifier",
        "50 a second, bright",
        rolled_m,
        f"{most(verdicts)}; the robot is driven by what the stranger shows",
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
        payload = encode_retina(np.zeros(spec.shape, np.uint8), spec, stamp.time_ns)
        self._publisher.put_raw(payload, pack_stamp(stamp), protobuf_encoding(RETINA.schema))

    def show(self, count: int) -> None:
        spec = PolicyContract().retina
        for _ in range(count):
            now_ns = time.monotonic_ns()
            bright = np.full(spec.shape, 200, np.uint8)
            self._publisher.put(encode_retina(bright, spec, now_ns), now_ns)
            time.sleep(0.02)


ATTACKS = (a_stranger_shows_retinas, a_retina_of_a_time_to_come, a_lone_stranger)
