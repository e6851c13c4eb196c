"""Somebody on the bus beside a real body and a real runtime, who hears all and can say anything."""

import json
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import (
    COMMAND,
    LEASE,
    POSE,
    RELEASE,
    RETINA,
    Quality,
    Topic,
)
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    UndecodableError,
    protobuf_encoding,
    unpack_stamp,
)
from support.processes import Process, reflexarc, said_line, started, wait_until

FOR_EVER = {"source_time_ns": 0, "valid_for_ns": 2**63 - 1}


class Witness:
    """Somebody on the bus who hears what the first body says and can say what it likes."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.leases: list[pb.Lease] = []
        self.x_m: list[float] = []
        self.way_m = 0.0
        """How far the body went since it was heard first, in whatever direction."""
        self.back_m = 0.0
        """How much of it went against x, the way ahead."""
        self.retina: Message | None = None
        self.commands: Counter[bytes] = Counter()
        """How many commands each sender sent."""
        self.last_command: pb.Command | None = None
        self.last_drive: Message | None = None
        """The last command that was no safe one; and how far the body had gone by then."""
        self.way_at_last_drive_m = 0.0
        self.body = b""
        self._place: tuple[float, float] | None = None
        bus.subscribe([LEASE], self._keep(pb.Lease, self.leases.append))
        bus.subscribe([POSE], self._keep(PoseInFrame, self._follow))
        bus.subscribe([RETINA], self._see)
        bus.subscribe([COMMAND], self._hear_command)

    def _keep(self, kind: type[ProtobufMessage], keep: Callable[[Any], None]) -> Any:
        def hear(message: Message) -> None:
            if self._is_of_the_body(message):
                keep(kind.FromString(message.payload))

        return hear

    def _is_of_the_body(self, message: Message) -> bool:
        sender = unpack_stamp(message.attachment).sender
        self.body = self.body or sender
        return sender == self.body

    def _follow(self, pose: PoseInFrame) -> None:
        here = (pose.pose.position.x, pose.pose.position.y)
        self.way_m += math.dist(here, self._place or here)
        self.back_m += max(0.0, (self._place or here)[0] - here[0])
        self._place = here
        self.x_m.append(here[0])

    def _see(self, message: Message) -> None:
        if self._is_of_the_body(message):
            self.retina = message

    def _hear_command(self, message: Message) -> None:
        try:
            sender, command = (
                unpack_stamp(message.attachment).sender,
                pb.Command.FromString(message.payload),
            )
        except (UndecodableError, DecodeError):
            return
        self.commands[sender] += 1
        self.last_command = command
        if command.HasField("source_time_ns"):
            self.last_drive, self.way_at_last_drive_m = message, self.way_m

    @property
    def stamp(self) -> Stamp:
        """Of the body's last retina: all that a stranger can know of it."""
        wait_until(lambda: self.retina is not None, "a retina")
        assert self.retina is not None
        return unpack_stamp(self.retina.attachment)

    @property
    def refused(self) -> dict[str, int]:
        """How many messages the body refused, by reason."""
        return dict(self.lease.refused)

    @property
    def lease(self) -> pb.Lease:
        wait_until(lambda: self.leases, "a lease")
        return self.leases[-1]

    def rolled_m(self, seconds: float = 0.5) -> float:
        """How far the body goes in that time."""
        wait_until(lambda: self.x_m, "a pose")
        begin_m = self.x_m[-1]
        time.sleep(seconds)
        return self.x_m[-1] - begin_m

    def publisher(self, topic: Topic, encoding: str = "") -> Any:
        encoding = encoding or protobuf_encoding(topic.schema)
        publisher = self.bus.publisher_of_key(topic.key("robot0"), encoding, Quality.CONTROL)
        # Others hear commands, too; only a body hears a release, after it hears commands.
        gate = self.bus.publisher(RELEASE)
        wait_until(lambda: publisher.has_listener and gate.has_listener, "a body that listens")
        return publisher

    def wait_for(self, holds: Callable[[pb.Lease], bool], what: str) -> None:
        wait_until(lambda: self.leases and holds(self.leases[-1]), what, 30.0)


@contextmanager
def witness(port: int) -> Iterator[Witness]:
    with Bus(BusConfig("robot0", port), time.monotonic_ns) as bus:
        yield Witness(bus)


@contextmanager
def body(policy: Path, port: int, cwd: Path, *words: object) -> Iterator[Process]:
    common = ("--policy", policy, "--port", port, "--rate", 50, "--json")
    with started("sim", *common, *words, cwd=cwd) as process:
        said_line(process, "reference-1")
        yield process


@contextmanager
def runtime(policy: Path, port: int, cwd: Path, *words: object) -> Iterator[Process]:
    with started("run", policy, "--port", port, "--no-guard", "--json", *words, cwd=cwd) as process:
        said_line(process, "reflexarc run:")
        yield process


def tell(port: int, *words: object) -> tuple[int, dict[str, Any]]:
    done = reflexarc(*words, "--port", port, "--json")
    said: dict[str, Any] = json.loads(done.stdout) if done.stdout else {}
    return done.returncode, {**said, "complaint": done.stderr}


def ahead(**fields: Any) -> bytes:
    command = pb.Command(verdict=pb.OK, linear_mps=1.0, source_sequence=0, **fields)
    return command.SerializeToString()


def joined(port: int, folder: Path) -> Path:
    """A Zenoh configuration that joins the bus of a body that listens already."""
    path = folder / "join.json5"
    path.write_text(
        f"""{{mode: "peer", listen: {{endpoints: ["tcp/127.0.0.1:0"]}},
        connect: {{endpoints: ["tcp/127.0.0.1:{port}"]}},
        scouting: {{multicast: {{enabled: false}}, gossip: {{enabled: true}}}}}}"""
    )
    return path
