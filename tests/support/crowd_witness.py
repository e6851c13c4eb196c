"""A Zenoh router, and a witness on it.

All processes are on one machine, with one monotonic clock: what belongs together is told by the
time in its stamp, so that a witness who is not woken mixes nothing up. Since when somebody lives is
the witness's own time, and so is how long it overslept.
"""

import json
import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import zenoh
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import COMMAND, CONTACT, LEASE, POSE
from reflexarc_runtime.messages.wire import Message, unpack_stamp
from support.crowd_judge import MS, Evidence, Step

PERIOD_S = 0.02
_NAP_S = 0.01
_OVERSLEPT_NS = 30 * MS
_WAITED_NS = 15 * MS
_AFTER_NS = 200 * MS
"""What an input that is too old costs on top: three good ones in a row, and a new lease."""


@contextmanager
def router(port: int) -> Iterator[None]:
    """A router on the loopback interface."""
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    try:
        yield
    finally:
        session.close()  # type: ignore[no-untyped-call]  # the stub has no type


def client_file(port: int, folder: Path) -> Path:
    """The configuration of whoever joins that router."""
    path = folder / "client.json5"
    path.write_text(
        f"""{{mode: "client", connect: {{endpoints: ["tcp/127.0.0.1:{port}"]}},
        scouting: {{multicast: {{enabled: false}}}}}}"""
    )
    return path


class Witness:
    """Hears all leases, commands and poses; and notes when it was not woken itself."""

    def __init__(self, bus: Bus) -> None:
        self.evidence = Evidence(defaultdict(list), defaultdict(list), {}, defaultdict(list))
        self.first_ns: dict[bytes, int] = {}
        self.last_ns: dict[bytes, int] = {}
        self.watched: dict[int, int] = {}
        """Processes, and how long each has waited for a processor, ns."""
        self.oversleeps: list[tuple[int, int]] = []
        self._poses: dict[bytes, tuple[int, float]] = {}
        self._ended = threading.Event()
        bus.subscribe([POSE], self._pose)
        bus.subscribe([LEASE], self._lease)
        bus.subscribe([CONTACT], self._contact)
        bus.subscribe([COMMAND], self._command)
        self._sleeper = threading.Thread(target=self._sleep, daemon=True)
        self._sleeper.start()

    def end(self) -> None:
        """No longer look at the clock."""
        self._ended.set()
        self._sleeper.join()

    def _pose(self, message: Message) -> None:
        stamp = unpack_stamp(message.attachment)
        x_m = PoseInFrame.FromString(message.payload).pose.position.x
        sender, at_ns = stamp.sender, stamp.time_ns
        steps = self.evidence.steps[sender]
        self.first_ns.setdefault(sender, message.received_ns)
        self.last_ns[sender] = message.received_ns
        number, before_m = self._poses.get(sender, (-1, 0.0))
        self._poses[sender] = stamp.sequence, x_m
        if stamp.sequence == number + 1 and number >= 0:
            steps.append(Step(at_ns, (x_m - before_m) / PERIOD_S))

    def _lease(self, message: Message) -> None:
        stamp = unpack_stamp(message.attachment)
        holder = pb.Lease.FromString(message.payload).holder
        self.evidence.leases[stamp.sender].append((stamp.time_ns, holder))

    def _contact(self, message: Message) -> None:
        stamp = unpack_stamp(message.attachment)
        self.evidence.contacts.add((stamp.sender, stamp.time_ns))

    def _command(self, message: Message) -> None:
        stamp = unpack_stamp(message.attachment)
        sender, at_ns = stamp.sender, stamp.time_ns
        self.first_ns.setdefault(sender, message.received_ns)
        self.last_ns[sender] = message.received_ns
        command = pb.Command.FromString(message.payload)
        if command.verdict == pb.OK:
            self.evidence.speeds.setdefault(sender, command.linear_mps)
            self.evidence.commands[sender].append((at_ns, command.body))

    def _sleep(self) -> None:
        before_ns = time.monotonic_ns()
        while not self._ended.wait(_NAP_S):
            now_ns = time.monotonic_ns()
            if now_ns - before_ns > _OVERSLEPT_NS or self._somebody_waited():
                self.oversleeps.append((before_ns, now_ns + _AFTER_NS))
            before_ns = now_ns

    def _somebody_waited(self) -> bool:
        """Whether the kernel let a loop wait for a processor since the last look."""
        waited = False
        for pid, before_ns in list(self.watched.items()):
            now_ns = run_delay_ns(pid)
            waited |= now_ns - before_ns > _WAITED_NS
            self.watched[pid] = max(now_ns, before_ns)
        return waited


def run_delay_ns(pid: int) -> int:
    """How long a process's main thread has been ready and was not run: the kernel's own count."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text().split()[1])
    except (OSError, IndexError):
        return 0


@contextmanager
def witness(zenoh_file: Path) -> Iterator[Witness]:
    """A witness on the router's bus."""
    with Bus(BusConfig(zenoh_file=zenoh_file), time.monotonic_ns) as bus:
        seen = Witness(bus)
        try:
            yield seen
        finally:
            seen.end()
