"""A robot that speaks ROS 2: a Zenoh router, a scanner, and wheels that remember."""

import json
import socket
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import zenoh

from support.ros2 import Time, Twist, TwistStamped, laser_scan

SCAN_PERIOD_S = 0.02
HERE = Path(__file__).parent


@dataclass(frozen=True)
class Told:
    """One velocity command, as the robot received it."""

    arrived_ns: int
    """On the wall clock."""
    stamp_ns: int
    """In the header; 0 without one."""
    ahead_mps: float
    attachment: bytes

    @property
    def sender(self) -> bytes:
        """Who said it: the bridge, or on a busy machine its companion as well."""
        return self.attachment[-16:]

    @property
    def is_standstill(self) -> bool:
        return self.ahead_mps == 0.0


@dataclass
class Robot:
    """It scans an empty room 50 times a second, and hears commands."""

    session: zenoh.Session
    scan_key: str
    command_key: str
    stamped: bool
    told: list[Told] = field(default_factory=list)
    scanning: threading.Event = field(default_factory=threading.Event)

    def hear(self, sample: zenoh.Sample) -> None:
        data, now_ns = sample.payload.to_bytes(), time.time_ns()
        attachment = sample.attachment.to_bytes() if sample.attachment else b""
        if self.stamped:
            message = TwistStamped.deserialize(data)
            stamp, twist = message.header.stamp, message.twist
            stamp_ns = stamp.sec * 1_000_000_000 + stamp.nanosec
        else:
            stamp_ns, twist = 0, Twist.deserialize(data)
        self.told.append(Told(now_ns, stamp_ns, twist.linear.x, attachment))

    def scan(self, count: int | None = None) -> None:
        """Send scans until told to end, or so many."""
        publisher = self.session.declare_publisher(self.scan_key)
        number = 0
        while self.scanning.is_set() and number != count:
            seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
            scan = laser_scan([float("inf")] * 181, stamp=Time(seconds, nanoseconds))
            gid = bytes(range(16))
            attachment = struct.pack("<qqB16s", number, time.time_ns(), 16, gid)
            publisher.put(scan.serialize(), attachment=attachment)
            number += 1
            time.sleep(SCAN_PERIOD_S)

    def tokens(self) -> list[str]:
        """What `ros2 topic list` would list from."""
        replies = self.session.liveliness().get("@ros2_lv/**", timeout=1.0)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok]


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


@contextmanager
def router(port: int) -> Iterator[zenoh.Session]:
    """The Zenoh router of a robot."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("router"))
    config.insert_json5("scouting/multicast/enabled", json.dumps(False))
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    with zenoh.open(config) as session:
        yield session


@contextmanager
def rmw_robot_session(port: int) -> Iterator[zenoh.Session]:
    """A node of rmw_zenoh beside its rmw_zenohd, whose router listens on a port."""
    with rmw_router(port), rmw_node(port) as node:
        yield node


def rmw_router(port: int) -> zenoh.Session:
    """A router as rmw_zenohd is configured; a context manager."""
    return _as_configured("rmw_zenohd", port)


def rmw_node(port: int, identifier: str = "") -> zenoh.Session:
    """The session of a node as rmw_zenoh opens it; a context manager."""
    return _as_configured("rmw_session", port, identifier)


def _as_configured(name: str, port: int, identifier: str = "") -> zenoh.Session:
    """A session as a file beside this one says, with another port, and an identifier if given."""
    text = (HERE / f"{name}.json5").read_text().replace(":7447", f":{port}")
    config = zenoh.Config.from_json5(text)
    if identifier:
        config.insert_json5("id", json.dumps(identifier))
    return zenoh.open(config)


@contextmanager
def robot(
    port: int, scan_key: str, command_key: str, *, stamped: bool, rmw: bool = False
) -> Iterator[Robot]:
    """A robot whose router listens on a port; with `rmw` as rmw_zenoh has it."""
    with rmw_robot_session(port) if rmw else router(port) as session:
        body = Robot(session, scan_key, command_key, stamped)
        wheels = session.declare_subscriber(command_key, body.hear)
        body.scanning.set()
        scanner = threading.Thread(target=body.scan)
        scanner.start()
        try:
            yield body
        finally:
            body.scanning.clear()
            scanner.join()
            wheels.undeclare()
