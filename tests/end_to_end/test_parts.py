"""A real drive in parts, with a black box, a person's word and a kill in its midst."""

import json
import signal
import subprocess
from pathlib import Path

import pytest

from reflexarc_logs.container.manifest import read_manifest
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from support.plain_body import plain_body
from support.processes import reflexarc, started, wait_until


def ticks_of(path: Path) -> list[int]:
    return [tick.decision.index for tick in read_log(path).ticks()]


def end_of(process: "subprocess.Popen[str]") -> dict[str, object]:
    process.send_signal(signal.SIGINT)
    said, complaint = process.communicate(timeout=60.0)
    assert process.returncode == 0, complaint
    told: dict[str, object] = json.loads(said.splitlines()[-1])
    return told


def test_parts_follow_each_other_and_a_mark_makes_the_box_write(
    policy: Path, port: int, tmp_path: Path
):
    words = ["run", policy, "--no-guard", "--port", port, "--record", tmp_path / "whole", "--json"]
    words += ["--rotate-s", 1, "--black-box", 1, "--black-box-after", 0.5, "-o", tmp_path / "box"]
    with plain_body(PolicyContract(), port), started(*words) as run:
        wait_until((tmp_path / "whole" / "whole.part3.mcap.partial").exists, "the third part")
        assert not list((tmp_path / "box").glob("*.mcap*"))
        assert reflexarc("mark", "look here", "--port", port).returncode == 0
        wait_until((tmp_path / "box" / "box.mcap").exists, "what the box wrote")
        told = end_of(run)
    parts = log_paths([tmp_path / "whole"])
    assert told["parts"] == [str(part) for part in parts]
    assert told["black_box_parts"] == [str(tmp_path / "box" / "box.mcap")]
    indices = [index for part in parts for index in ticks_of(part)]
    assert indices == list(range(len(indices)))
    assert all(replay(log).exit_status == 0 for log in (*parts, tmp_path / "box" / "box.mcap"))
    (box,) = read_manifest(tmp_path / "box" / "box.parts.jsonl")
    assert box.why.startswith("mark: look here (tick ")
    words = ["--rotate-s", 1, "--seconds", 0.2, "--port", port]
    again = reflexarc("record", "-o", tmp_path / "whole", *words)
    assert (again.returncode, len(list((tmp_path / "whole").glob("*.parts.jsonl")))) == (0, 2)
    named = reflexarc("record", "-o", tmp_path / "whole" / "whole.mcap", *words)
    assert (named.returncode, "exists already" in named.stderr) == (2, False)
    assert "parts of another recording are there" in named.stderr


@pytest.mark.long
def test_a_kill_leaves_whole_parts_and_one_to_recover(policy: Path, port: int, tmp_path: Path):
    words = ["run", policy, "--no-guard", "--port", port, "--record", tmp_path / "a.mcap"]
    with plain_body(PolicyContract(), port), started(*words, "--rotate-s", 1) as run:
        wait_until((tmp_path / "a.part3.mcap.partial").exists, "the third part")
        run.kill()
        run.wait()
    for partial in tmp_path.glob("*.partial"):
        recover(partial, partial.with_suffix(""))
    parts = log_paths([tmp_path / "a.parts.jsonl"])
    indices = [index for part in parts for index in ticks_of(part)]
    assert len(indices) > 90
    assert indices == list(range(len(indices)))
    assert all(replay(part).exit_status == 0 for part in parts if ticks_of(part))
