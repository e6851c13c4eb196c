"""Floods the bus of a robot, as a process of its own, and prints what it reached.

python tests/support/flooder.py KIND PORT SECONDS
"""

import json
import os
import sys
import time
from collections.abc import Callable

import zenoh

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import COMMAND, LEASE, RETINA, SCAN, STATUS, TOPICS, Topic
from reflexarc_runtime.messages.wire import Stamp, pack_stamp, protobuf_encoding

RATE_HZ = 10_000
SENDERS = 10_000
TOKENS = 10_000
LARGE_BYTES = 200_000_000
BURST = 10
KINDS = (
    "command",
    "retina",
    "scan",
    "stop",
    "reset",
    "arm",
    "lease",
    "status",
    "senders",
    "attachments",
    "keys",
    "large",
    "tokens",
)
_STRANGER = b"a stranger, 16 b"
_DROP = zenoh.CongestionControl.DROP


def main() -> None:
    """Flood, and say how much was sent."""
    kind, port, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
    session = zenoh.open(_config(port))
    time.sleep(0.5)
    begin_s = time.monotonic()
    if kind == "tokens":
        kept = [session.liveliness().declare_token(f"robot0/alive/x{n}") for n in range(TOKENS)]
        sent, began_s = len(kept), time.monotonic() - begin_s
        time.sleep(max(0.0, seconds - began_s))
    elif kind == "large":
        sent = _large(session, begin_s + seconds)
    else:
        sent = _many(_sender_of(kind, session), begin_s + seconds)
    print(json.dumps({"sent": sent, "seconds": time.monotonic() - begin_s}), flush=True)
    os._exit(0)  # a session under pressure takes long to close, and nobody waits for a stranger


def _config(port: int) -> zenoh.Config:
    config = zenoh.Config()
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    return config


def _many(send: Callable[[int], None], end_s: float) -> int:
    """At 10 kHz, or as fast as it goes."""
    sent, due_s = 0, time.monotonic()
    while due_s < end_s and time.monotonic() < end_s:
        for _ in range(BURST):
            send(sent)
            sent += 1
        due_s += BURST / RATE_HZ
        time.sleep(max(0.0, due_s - time.monotonic()))
    return sent


def _large(session: zenoh.Session, end_s: float) -> int:
    payload, sent = bytes(LARGE_BYTES), 0
    while time.monotonic() < end_s:
        for topic in (COMMAND, RETINA):
            key, encoding = topic.key("robot0"), protobuf_encoding(topic.schema)
            stamp = pack_stamp(Stamp(sent, 0, _STRANGER))
            # It waits for its turn: a stranger is not so kind as to drop what it sends.
            waits = zenoh.CongestionControl.BLOCK
            session.put(key, payload, encoding=encoding, attachment=stamp, congestion_control=waits)
            sent += 1
    return sent


def _sender_of(kind: str, session: zenoh.Session) -> Callable[[int], None]:
    if kind == "keys":
        tail = "x" * 4000
        return lambda n: session.put(f"robot0/{tail}/command", b"x", congestion_control=_DROP)
    topic = next((topic for topic in TOPICS if topic.name == kind), COMMAND)
    publisher = session.declare_publisher(
        topic.key("robot0"),
        encoding=zenoh.Encoding(protobuf_encoding(topic.schema)),
        congestion_control=_DROP,
    )
    payload = _payload_of(topic)
    if kind == "senders":
        names = [n.to_bytes(16, "big") for n in range(1, SENDERS + 1)]
        return lambda n: publisher.put(
            payload, attachment=pack_stamp(Stamp(n, 0, names[n % SENDERS]))
        )
    if kind == "attachments":
        return lambda n: publisher.put(payload, attachment=bytes(n % 3000))
    return lambda n: publisher.put(payload, attachment=pack_stamp(Stamp(n, n, _STRANGER)))


def _payload_of(topic: Topic) -> bytes:
    if topic is COMMAND:
        command = pb.Command(verdict=pb.OK, linear_mps=1.0, source_time_ns=0, valid_for_ns=2**62)
        return command.SerializeToString()
    if topic is LEASE:
        return pb.Lease(holder=_STRANGER, epoch=7, armed=True, state="driving").SerializeToString()
    if topic is STATUS:
        return pb.Status(node="runtime", ticks=7, recording="on").SerializeToString()
    return b"" if topic in (RETINA, SCAN) else topic.message().SerializeToString()


if __name__ == "__main__":
    main()
