"""What `reflexarc top` shows of runtimes on a real bus, and who is told that nobody is there."""

import json
import os
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from prometheus_client.parser import text_string_to_metric_families

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.topics import LEASE, STATUS
from support.fleet_words import lease, status
from support.processes import finished, reflexarc, said_line, started, wait_for_records, wait_until

RUN = ("run", "--no-guard", "--no-watchdog", "--json")


@pytest.fixture
def body(port: int) -> Iterator[Bus]:
    """Somebody who listens at a port, as a body does."""
    with Bus(BusConfig("robot0", port, listens=True), time.monotonic_ns) as bus:
        yield bus


def seen(port: int) -> dict[str, Any]:
    """What `top --once --json` says."""
    done = reflexarc("top", "--once", "--json", "--port", port, "--patience", 30)
    assert done.returncode == 0, done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def test_a_runtime_is_seen_as_its_log_says_and_its_metrics_agree(
    policy: Path, body: Bus, port: int, tmp_path: Path
):
    """Nothing is sent to the loop, so it stands; the body's lease names nobody."""
    log = tmp_path / "drive.mcap"
    own = ("--record", log, "--metrics", 0, "--port", port)
    with started(*RUN, policy, *own) as runtime:
        address = said_line(runtime, "metrics at").rpartition(" ")[2].strip()
        wait_for_records(log, "status", 2)
        body.publisher(LEASE).put(lease(armed=True, state="standing").payload, 1)
        (robot,) = seen(port)["robots"]
        with urllib.request.urlopen(address, timeout=60.0) as answer:
            scraped = answer.read().decode()
        finished(runtime, signal.SIGINT)
    (shown,) = robot["runtimes"]
    assert robot["nodes"] == ["runtime"]
    assert (shown["verdict"], shown["action"], shown["recording"]) == ("NO_INPUT", "", "on")
    assert (shown["pace"], shown["contract_rate_hz"]) == ("rate", 50.0)
    ticks = [tick.decision for tick in read_log(log).ticks()]
    assert shown["verdicts"] == {"NO_INPUT": shown["ticks"]}
    assert 0 < shown["ticks"] < len(ticks)
    assert {tick.policy_hash for tick in ticks} == {shown["policy_hash"]}
    assert shown["policy"] == "/".join(policy.parts[-2:])
    families = {family.name: family for family in text_string_to_metric_families(scraped)}
    (counted,) = families["reflexarc_ticks"].samples
    assert counted.labels == {"robot": "robot0", "verdict": "NO_INPUT"}
    assert 0 < counted.value < len(ticks)


def test_robots_of_others_strange_names_and_garbage_are_shown_or_counted(body: Bus, port: int):
    """Whoever publishes on `*/status` is listened to, whatever the robot is called."""
    names = ("robot0", "rover-7", "\x1b[2Jx")
    with Bus(BusConfig("rover-7", port), time.monotonic_ns) as other:
        publishers = [
            other.publisher_of_key(STATUS.key(name), status().encoding, STATUS.quality)
            for name in names
        ]
        garbage = other.publisher_of_key("robot9/status", "text/plain", STATUS.quality)
        with started("top", "--json", "--port", port) as top:
            assert top.stdout is not None
            wait_until(lambda: publishers[0].has_listener, "a listener")

            def now() -> dict[str, Any]:
                for publisher in publishers:
                    publisher.put(status(rate_hz=50.0).payload, 1)
                garbage.put(b"x", 1)
                assert top.stdout is not None
                result: dict[str, Any] = json.loads(top.stdout.readline())
                return result

            wait_until(lambda: len(now()["robots"]) == 3, "three robots")
            said = now()
            top.send_signal(signal.SIGINT)
            assert top.wait(60.0) == 0
    assert [one["robot"] for one in said["robots"]] == ["\\x1b[2Jx", "robot0", "rover-7"]
    assert said["totals"]["unreadable"] > 0


def test_nobody_is_status_1_and_a_line_that_says_where_it_looked(port: int):
    done = reflexarc("top", "--once", "--json", "--port", port, "--patience", 0.2)
    assert (done.returncode, json.loads(done.stdout)["robots"]) == (1, [])
    (line,) = done.stderr.splitlines()
    assert line.startswith("reflexarc top: no robot was heard within 0.2 s: nobody answers at tcp/")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--patience", 0), "--patience: expected above 0 to 3600 s, got 0.0"),
        (("--once", "--metrics", 0), "--once: expected no --metrics beside it"),
        (("--metrics", 70_000), "--metrics: expected a port, 0 to 65535, got 70000"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_line(words: tuple[object, ...], expected: str):
    done = reflexarc("top", *words)
    (line,) = done.stderr.splitlines()
    assert done.returncode == 2
    assert expected in line


def test_a_port_in_use_ends_a_run_before_anything_is_recorded(
    policy: Path, body: Bus, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    done = reflexarc(*RUN, policy, "--record", log, "--metrics", port, "--port", port)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith(
        f"reflexarc: --metrics {port}: expected a free port of 127.0.0.1"
    )
    assert list(tmp_path.iterdir()) == []


def test_the_live_table_ends_with_q_and_restores_the_terminal(body: Bus, port: int):
    """On a pseudo-terminal of 24 lines and 80 columns."""
    body.publisher(STATUS).put(b"", 1)
    master, terminal = os.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80", "LINES": "24"}
    words = [sys.executable, "-m", "reflexarc", "top", "--port", str(port)]
    top = subprocess.Popen(
        words, stdin=terminal, stdout=terminal, env=environment, start_new_session=True
    )
    try:
        said = b""
        while b"q ends" not in said:
            said += os.read(master, 1 << 16)
        top.send_signal(signal.SIGTERM)
        while top.poll() is None:
            time.sleep(0.05)
    finally:
        top.kill()
        top.wait()
        os.close(terminal)
    said += os.read(master, 1 << 16)
    os.close(master)
    assert top.returncode == 0
    assert b"\x1b[?1049h" in said  # the other screen,
    assert b"\x1b[?1049l" in said  # and back
