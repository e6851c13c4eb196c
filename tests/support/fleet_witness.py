"""Somebody on the bus of many robots, who hears what each runtime says and what each is told."""

import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.wire import Message, unpack_stamp
from support.fleet_judge import SeenRobot


class FleetWitness:
    """Keeps every status of the runtimes, when each command came, and who holds each lease."""

    def __init__(self, bus: Bus) -> None:
        self.seen: list[SeenRobot] = []
        """One for each status of a runtime."""
        self.commands_ns: dict[str, list[int]] = defaultdict(list)
        """When each command of a robot came here."""
        self.obeyed: dict[str, int] = defaultdict(int)
        """How often a robot's body said that it obeys somebody."""
        self._holders: dict[str, str] = {}
        self._lock = threading.Lock()
        bus.subscribe_to_key("*/status", self._status)
        bus.subscribe_to_key("*/lease", self._lease)
        bus.subscribe_to_key("*/command", self._command)

    def obeying(self) -> list[str]:
        """The robots whose bodies have obeyed somebody."""
        return [robot for robot, times in list(self.obeyed.items()) if times]

    def seen_since(self, from_ns: int) -> list[SeenRobot]:
        """What was seen from a moment on: before, not everybody has found everybody."""
        return [one for one in self.seen if one.at_ns >= from_ns]

    def _status(self, message: Message) -> None:
        try:
            status = pb.Status.FromString(message.payload)
        except DecodeError:
            return
        if status.node != "runtime" or not status.ticks:  # the watchdog's own say nothing of ticks
            return
        robot = message.key.split("/")[0]
        seen = SeenRobot(
            robot,
            unpack_stamp(message.attachment).time_ns,
            status.ticks,
            status.rate_hz,
            dict(status.verdicts),
            status.policy_hash,
            self._holders.get(robot, ""),
            status.skipped_slots,
        )
        with self._lock:
            self.seen.append(seen)

    def _lease(self, message: Message) -> None:
        robot, lease = message.key.split("/")[0], pb.Lease.FromString(message.payload)
        self._holders[robot] = lease.holder.hex()
        self.obeyed[robot] += bool(lease.holder)

    def _command(self, message: Message) -> None:
        self.commands_ns[message.key.split("/")[0]].append(message.received_ns)


@contextmanager
def fleet_witness(port: int) -> Iterator[FleetWitness]:
    """A witness on the bus whose first body listens on a port."""
    with Bus(BusConfig("witness", port), time.monotonic_ns) as bus:
        yield FleetWitness(bus)
