"""Somebody on the bus who watches a body; and bodies and runtimes as real processes beside it."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import LEASE, POSE, RETINA, Quality, Topic
from reflexarc_runtime.messages.wire import Message, protobuf_encoding, unpack_stamp
from support.processes import Process, reflexarc, said_line, started, wait_until


class Witness:
    """Somebody on the bus who hears what the first body says and can say what it likes."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.leases: list[pb.Lease] = []
        self.x_m: list[float] = []
        self.retina: Message | None = None
        self.body = b""
        bus.subscribe([LEASE], self._keep(pb.Lease, self.leases.append))
        bus.subscribe([POSE], self._keep(PoseInFrame, lambda p: self.x_m.append(p.pose.position.x)))
        bus.subscribe([RETINA], self._see)

    def _keep(self, kind: type[ProtobufMessage], keep: Callable[[Any], None]) -> Any:
        def hear(message: Message) -> None:
            sender = unpack_stamp(message.attachment).sender
            self.body = self.body or sender
            if sender == self.body:
                keep(kind.FromString(message.payload))

        return hear

    def _see(self, message: Message) -> None:
        self.retina = message

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
        wait_until(lambda: publisher.has_listener, f"a listener of {topic.name}")
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
