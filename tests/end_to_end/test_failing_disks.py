"""Real processes whose recording is lost: said in time, exit status 1, and the robot goes on.

`python tests/campaigns/disks.py` has fifteen kinds, on real mounts.
"""

import json
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.topics import STATUS
from reflexarc_runtime.messages.wire import Message
from support.plain_body import plain_body
from support.processes import started, wait_for_records, wait_until

FILE_BYTES = 60_000


def end_of(process: "subprocess.Popen[str]") -> tuple[int, dict[str, Any]]:
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=60.0)
    return process.returncode, json.loads(said.splitlines()[-1])


def said_of(statuses: list[str]) -> Callable[[Message], None]:
    def hear(message: Message) -> None:
        status = pb.Status.FromString(message.payload)
        if status.node == "runtime":
            statuses.append(status.recording)

    return hear


@pytest.mark.long
def test_a_deleted_recording_is_said_and_goes_on_in_a_new_part(
    policy: Path, port: int, tmp_path: Path
):
    log, statuses = tmp_path / "a.mcap", []
    words = (policy, "--no-guard", "--record", log, "--port", port, "--json")
    with plain_body(PolicyContract(), port), started("run", *words) as run:
        with Bus(BusConfig(port=port), time.monotonic_ns) as bus:
            bus.subscribe([STATUS], said_of(statuses))
            wait_for_records(log, "tick", 60)
            (tmp_path / "a.mcap.partial").unlink()
            wait_until(lambda: "stopped: the file was deleted" in statuses, "the words", 20.0)
            again = "on, again in a.part2.mcap after: the file was deleted"
            wait_until(lambda: again in statuses, "a new part", 20.0)
        exit_status, said = end_of(run)
    assert exit_status == 1
    assert said["parts"] == [str(tmp_path / "a.part2.mcap")]
    assert replay(tmp_path / "a.part2.mcap").exit_status == 0


@pytest.mark.long
def test_a_limit_on_files_makes_parts_that_all_replay(policy: Path, port: int, tmp_path: Path):
    log = tmp_path / "a.mcap"
    words = (policy, "--no-guard", "--record", log, "--port", port, "--json")
    limit = (FILE_BYTES, FILE_BYTES)
    with (
        plain_body(PolicyContract(), port),
        subprocess.Popen(
            [sys.executable, "-m", "reflexarc", "run", *map(str, words)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit),  # takes no lock
        ) as run,
    ):
        second = tmp_path / "a.part2.mcap.partial"
        wait_until(lambda: second.exists() and second.stat().st_size > 20_000, "a part", 60.0)
        exit_status, said = end_of(run)
    assert exit_status == 1
    assert said["parts"][0] == str(tmp_path / "a.mcap.partial")
    recover(tmp_path / "a.mcap.partial", tmp_path / "first.mcap")
    assert replay(tmp_path / "first.mcap").exit_status == 0
    assert replay(tmp_path / "a.part2.mcap").exit_status == 0
