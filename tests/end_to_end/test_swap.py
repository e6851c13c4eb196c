"""Policies that take over from each other in a real runtime, over a real bus."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.model_file import policy_hash
from support.policies import exported
from support.processes import finished, reflexarc, started, wait_for_records, wait_until

RUN = ("run", "--no-guard", "--no-watchdog", "--json")


@pytest.fixture
def meeting(port: int) -> Iterator[int]:
    """A port at which somebody listens, as a body does: there runtime and operator meet."""
    with Bus(BusConfig("robot0", port, listens=True), time.monotonic_ns):
        yield port


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("policies")
    paths = [folder / f"p{seed}.onnx" for seed in range(3)]
    for seed, path in enumerate(paths):
        path.write_bytes(exported(PolicyContract(), seed=seed))
    return paths


def hash_of(path: Path) -> str:
    return policy_hash(path.read_bytes())


def test_a_swap_takes_over_at_standstill_is_refused_without_leave_and_replays(
    files: list[Path], meeting: int, tmp_path: Path
):
    """Nothing is sent to the loop, so it commands to stand all the time."""
    log, to = tmp_path / "drive.mcap", ("--port", meeting)
    first, second, shadow = files
    more = ("--record", log, "--allow-swap", "--shadow", shadow)
    with started(*RUN, first, *to, *more) as runtime:
        wait_for_records(log, "tick", 5)
        said = reflexarc("swap", second, *to, "--json", "--patience", 20)
        assert said.returncode == 0, said.stderr
        (answer,) = json.loads(said.stdout)["answers"]
        assert (answer["outcome"], answer["policy_hash"]) == ("taken", hash_of(second))
        damaged = tmp_path / "damaged.onnx"
        damaged.write_bytes(second.read_bytes()[:-40])
        refused = reflexarc("swap", damaged, *to)
        assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
        end = finished(runtime, signal.SIGINT)
    assert [one["policy_hash"] for one in end["swaps"]] == [hash_of(second)]
    assert end["shadow"]["policy_hash"] == hash_of(shadow)
    ticks = [tick.decision for tick in read_log(log).ticks()]
    hashes = [tick.policy_hash for tick in ticks]
    at = int(answer["tick"])
    assert set(hashes[:at]) == {hash_of(first)}
    assert set(hashes[at:]) == {hash_of(second)}
    assert replay(log, level="node").verdict == "identical"


def test_a_runtime_that_was_not_told_so_takes_no_other_policy(
    files: list[Path], meeting: int, tmp_path: Path
):
    with started(*RUN, files[0], "--port", meeting) as runtime:
        said = reflexarc("swap", files[1], "--port", meeting, "--patience", 20)
        assert said.returncode == 1
        assert "start it with --allow-swap" in said.stderr
        finished(runtime, signal.SIGINT)


def test_a_signed_policy_takes_over_where_signatures_are_asked_for_and_an_unsigned_one_does_not(
    meeting: int, tmp_path: Path
):
    pytest.importorskip("cryptography")
    paths = [tmp_path / f"p{seed}.onnx" for seed in range(3)]
    for seed, path in enumerate(paths):
        path.write_bytes(exported(PolicyContract(), seed=seed))
    first, signed, unsigned = paths
    assert reflexarc("secure", "key", tmp_path / "mine.key").returncode == 0
    for path in (first, signed):
        assert reflexarc("secure", "sign", path, "--key", tmp_path / "mine.key").returncode == 0
    to = ("--port", meeting)
    trust = ("--allow-swap", "--require-signature", tmp_path / "mine.pub")
    with started(*RUN, first, *to, *trust) as runtime:
        refused = reflexarc("swap", unsigned, *to, "--patience", 20)
        assert refused.returncode == 1
        assert "expected a signature" in refused.stderr
        taken = reflexarc("swap", signed, *to, "--patience", 20)
        assert taken.returncode == 0, taken.stderr
        end = finished(runtime, signal.SIGINT)
    assert [one["policy_hash"] for one in end["swaps"]] == [hash_of(signed)]


@pytest.mark.long
def test_killed_in_the_midst_of_a_swap_its_log_recovers_and_replays_and_nothing_is_left(
    files: list[Path], meeting: int, tmp_path: Path
):
    log, to = tmp_path / "drive.mcap", ("--port", meeting)
    with started(*RUN, files[0], *to, "--record", log, "--allow-swap") as runtime:
        wait_for_records(log, "tick", 60)
        words = [sys.executable, "-m", "reflexarc", "swap", str(files[1]), "--port", str(meeting)]
        with subprocess.Popen(words, stderr=subprocess.PIPE) as asking:
            time.sleep(1.5)
            children = children_of(runtime.pid)
            runtime.kill()
            runtime.wait()
            asking.wait(120)
        wait_until(lambda: not any(map(is_alive, children)), "the end of all its processes")
    recovered = tmp_path / "recovered.mcap"
    reflexarc("recover", f"{log}.partial", "-o", recovered)  # 1: its end is missing
    assert replay(recovered, level="node").verdict == "identical"


def children_of(pid: int) -> list[int]:
    """The processes that a process has started."""
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(word) for word in text.split()]


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "Z" not in Path(f"/proc/{pid}/stat").read_text().split()[2]
