"""Small samples of the campaigns `crowd.py` and `floods.py`, and what the bus does not let in."""

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import COMMAND, Quality
from reflexarc_runtime.messages.wire import (
    MAX_ATTACHMENT_BYTES,
    MAX_PAYLOAD_BYTES,
    TOO_LARGE,
    Message,
)
from support import flooder
from support.crowd_judge import moved_by_others
from support.crowd_witness import client_file, router, witness
from support.processes import said_line, started, wait_until


def test_what_is_too_large_is_not_copied_and_what_is_huge_does_not_arrive(port: int):
    heard: list[Message] = []
    with (
        Bus(BusConfig(port=port, listens=True), time.monotonic_ns) as body,
        Bus(BusConfig(port=port), time.monotonic_ns) as stranger,
    ):
        body.subscribe([COMMAND], heard.append)
        publisher: Any = stranger.publisher_of_key("robot0/command", "", Quality.CONTROL)
        wait_until(lambda: publisher.has_listener, "a listener", 20.0)

        def arrived(payload: bytes, attachment: bytes, encoding: str = "") -> Message:
            """The message, sent until it comes: a busy bus drops what is large."""
            count = len(heard)

            def came() -> bool:
                publisher.put_raw(payload, attachment, encoding)
                return len(heard) > count

            wait_until(came, "a message", 20.0)
            time.sleep(0.3)
            return heard[-1]

        for _ in range(3):
            publisher.put_raw(bytes(32 << 20), b"huge", "")
            time.sleep(0.2)
        largest = arrived(bytes(MAX_PAYLOAD_BYTES), b"exact")
        more = arrived(bytes(MAX_PAYLOAD_BYTES + 7), b"more")
        long = arrived(b"", bytes(5 * MAX_ATTACHMENT_BYTES))
    assert all(message.attachment != b"huge" for message in heard)
    assert (len(largest.payload), largest.attachment) == (MAX_PAYLOAD_BYTES, b"exact")
    assert more.payload is TOO_LARGE
    assert len(long.attachment) == MAX_ATTACHMENT_BYTES


@pytest.mark.long
def test_through_a_router_of_two_runtimes_one_moves_the_body(policy: Path, tmp_path: Path):
    from support.fault_runs import free_ports

    (port,) = free_ports(1)
    joined = client_file(port, tmp_path)
    words = ("--zenoh", joined, "--json")
    with (
        router(port),
        witness(joined) as seen,
        started("sim", "--policy", policy, "--rate", 50, *words, cwd=tmp_path),
        started("run", policy, "--no-guard", *words, cwd=tmp_path) as first,
        started("run", policy, "--no-guard", *words, cwd=tmp_path),
    ):
        wait_until(lambda: len(seen.evidence.commands) == 2, "two that command", 60.0)
        time.sleep(1.0)
        first.kill()
        time.sleep(1.0)
        (steps,) = seen.evidence.steps.values()
        assert sum(step.ahead_mps > 0.02 for step in steps) > 10
        assert not moved_by_others(seen.evidence)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["command", "senders"])
def test_a_flood_changes_nothing_of_who_is_obeyed(
    kind: str, policy: Path, port: int, tmp_path: Path
):
    with started("sim", "--policy", policy, "--port", port, "--json", cwd=tmp_path) as body:
        said_line(body, "reference-1")
        with (
            started("run", policy, "--no-guard", "--port", port, cwd=tmp_path),
            witness(client_file(port, tmp_path)) as seen,
        ):
            wait_until(lambda: seen.evidence.commands, "a drive", 60.0)
            words = [sys.executable, flooder.__file__, kind, str(port), "2"]
            subprocess.run(words, check=True, capture_output=True)
            # Commands of the flood name no body; those of the runtime do.
            evidence = seen.evidence
            strangers = {s for s, sent in evidence.commands.items() if not any(b for _, b in sent)}
            assert strangers
            holders = {h for said in evidence.leases.values() for _, h in said}
            assert not holders & strangers
            assert body.poll() is None
