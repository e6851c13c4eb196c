"""A stranger's commands to a robot that a runtime drives ahead: can it drive it back?"""

import time
from collections.abc import Callable, Iterator
from threading import Thread

from campaigns.attacks.lies import Lie, Spoken, anonymous, command
from campaigns.attacks.outcome import Outcome, counts, held_if, known_if
from campaigns.attacks.stage import Scene, Stage
from campaigns.attacks.strangers import put, settle
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Publisher
from reflexarc_runtime.messages.topics import COMMAND, RELEASE
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp

FLOOD_S = 2.0
BACK = {"linear_mps": -1.0}
SAFE = pb.Command(action=-1, verdict=pb.STOPPED).SerializeToString()


def at_500_hz(stage: Stage) -> Iterator[Outcome]:
    """Three floods, none by the holder of the lease: the robot goes on ahead."""
    floods = {
        "backwards, in order": lambda stamp: Spoken(command(stamp, **BACK)),
        "anonymous, for ever": lambda _: Spoken(anonymous(), b""),
        "safe": lambda _: Spoken(SAFE),
    }
    with stage.driving() as scene:
        for name, lie in floods.items():
            before, lease = scene.seen.refused, scene.seen.lease
            back_m, ahead_m, sent = _flood(scene, lie)
            # On a busy machine a runtime is silent for 100 ms, and then the lease is free for all.
            silent = scene.seen.lease.epoch - lease.epoch
            said = f"its epoch grew by {silent}, as the runtime was silent" if silent else "held"
            yield Outcome(
                f"a runtime drives; a stranger's commands, {name}",
                f"{sent} in {FLOOD_S:g} s",
                back_m,
                f"{ahead_m:.2f} m ahead meanwhile; the lease: {said}; "
                f"{counts(scene.seen.refused, before)}",
                known_if(back_m > 0.0) if silent else held_if(back_m == 0.0 and ahead_m > 1.0),
            )


def impersonated(stage: Stage) -> Iterator[Outcome]:
    """A stranger whose commands carry the runtime's identifier: nothing tells them apart."""
    with stage.driving() as scene:
        own = pack_stamp(Stamp(0, 0, scene.seen.lease.holder))
        back_m, ahead_m, sent = _flood(scene, lambda stamp: Spoken(command(stamp, **BACK), own))
        yield Outcome(
            "the same with the runtime's own identifier",
            f"{sent} in {FLOOD_S:g} s",
            back_m,
            f"{ahead_m:.2f} m ahead meanwhile; {scene.seen.lease.state}",
            known_if(back_m > 0.0),
        )


def squatted(stage: Stage) -> Iterator[Outcome]:
    """A stranger who got the lease first, by safe commands: the robot stands, and says why."""
    with stage.standing() as scene:
        publisher, ended = scene.seen.publisher(COMMAND), time.monotonic() + 60.0
        stranger = Thread(target=lambda: _hold(publisher, lambda: time.monotonic() > ended))
        stranger.start()
        scene.seen.wait_for(lambda lease: bool(lease.holder), "a holder")
        with scene.runtime():
            reason = "another one holds the lease"
            scene.seen.wait_for(lambda lease: lease.refused[reason] > 100, "a runtime that waits")
            rolled_m, said = scene.seen.way_m, counts(scene.seen.refused)
            # On a busy machine the stranger is silent for 100 ms, too, and the runtime comes first.
            was_lost = scene.seen.lease.epoch > 1
            ended = 0.0
            stranger.join()
            scene.seen.wait_for(lambda lease: lease.state == "driving", "a drive")
    yield Outcome(
        "a stranger holds the lease first, by safe commands; a runtime comes",
        "100 a second",
        rolled_m,
        f"{said}; the runtime drives {'whenever' if was_lost else 'once'} the stranger is silent",
        held_if(rolled_m == 0.0 or was_lost),
    )


def _hold(publisher: Publisher, is_over: Callable[[], bool]) -> None:
    while not is_over():
        publisher.put(SAFE, 0)
        time.sleep(0.01)


def taken_over(stage: Stage) -> Iterator[Outcome]:
    """A release is heard from everybody; so a stranger can be the next holder."""
    with stage.driving() as scene:
        holder, release = scene.seen.lease.holder, scene.seen.publisher(RELEASE)
        release.put(pb.Release(reason="mine").SerializeToString(), time.monotonic_ns())
        back_m, _, sent = _flood(scene, lambda stamp: Spoken(command(stamp, **BACK)))
        scene.seen.wait_for(lambda lease: lease.holder == holder, "the runtime holds it again")
        yield Outcome(
            "a release, then a stranger's commands backwards, in order",
            f"1 release, {sent} commands in {FLOOD_S:g} s",
            back_m,
            f"epoch {scene.seen.lease.epoch}; after its silence the runtime holds the lease again",
            known_if(back_m > 0.0),
        )


def recorded(stage: Stage) -> Iterator[Outcome]:
    """Commands that the true runtime has sent, said again once it is gone."""
    heard: list[Message] = []
    with stage.driving() as scene:
        scene.seen.bus.subscribe([COMMAND], heard.append)
        time.sleep(2.0)
        scene.loop.kill()
        scene.seen.wait_for(lambda lease: not lease.holder, "the lease is free")
        kept = [message for message in heard if message.attachment]
        yield _said_again(scene, kept, "to the same body")
    with stage.standing() as scene:
        yield _said_again(scene, kept, "to the body after it was started again")


def _said_again(scene: Scene, messages: list[Message], where: str) -> Outcome:
    publisher = scene.seen.publisher(COMMAND)
    before, begun_m = scene.seen.refused, scene.seen.way_m
    for message in messages:
        publisher.put_raw(message.payload, message.attachment, message.encoding)
        time.sleep(0.01)
    settle(scene.seen)
    rolled_m = scene.seen.way_m - begun_m
    return Outcome(
        f"the runtime's own commands, recorded, {where}",
        f"{len(messages)}, 100 a second",
        rolled_m,
        counts(scene.seen.refused, before),
        held_if(rolled_m == 0.0 and len(messages) > 50),
    )


def _flood(scene: Scene, lie: Lie) -> tuple[float, float, int]:
    """500 commands a second: metres back and ahead, and how many."""
    publisher, seen = scene.seen.publisher(COMMAND), scene.seen
    back_m, way_m, sent = seen.back_m, seen.way_m, 0
    begin_s = time.monotonic()
    while (now_s := time.monotonic() - begin_s) < FLOOD_S:
        while sent < now_s * 500:
            put(scene, publisher, lie)
            sent += 1
        time.sleep(0.001)
    back_m, ahead_m = seen.back_m - back_m, seen.way_m - way_m
    settle(seen)
    return back_m, ahead_m - back_m, sent


ATTACKS = (at_500_hz, impersonated, squatted, taken_over, recorded)
