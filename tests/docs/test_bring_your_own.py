"""The page's own lines: a torch module, a model of PPO and a Python object drive a body."""

import re
import signal
from pathlib import Path
from typing import Any

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.policy.policy import load_policy
from support.fault_runs import free_ports
from support.processes import finished, started

PAGE = (Path(__file__).parents[2] / "docs" / "bring-your-own.md").read_text()
MODULE, PPO, LOOP, CALL = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
TICKS = 60


def test_all_three_drive_are_recorded_and_replay_or_say_why_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for block in (MODULE, LOOP):
        exec(block, names)
    files = ["module.onnx"]
    if has_stable_baselines3():
        exec(PPO, names)
        files.append("ppo.onnx")
    [port] = free_ports(1)
    names["drive"] = on_port(names["drive"], port)
    with started("sim", "--policy", "module.onnx", "--port", port, "--json") as body:
        wait_for_the_body(names)
        for name in files:
            policy = load_policy(name)
            given = {"file": policy.data, "identity": policy.policy_hash}
            names["drive"](policy, policy.contract, f"{name}.mcap", TICKS, **given)
        exec(CALL.replace("100", str(TICKS)), names)
        finished(body, signal.SIGINT)
    assert names["summary"].verdicts["OK"] > TICKS // 2
    for name in files:
        report = replay(f"{name}.mcap")
        assert report.exit_status == 0
        assert report.levels[0].compared > TICKS // 2
    assert len(list(read_log("steer-away.mcap").ticks())) == TICKS + 1
    with pytest.raises(LogError, match="no policy is attached"):
        replay("steer-away.mcap")


def wait_for_the_body(names: dict[str, Any]) -> None:
    """Drive a little, again and again, until it shows something: it may have to be compiled."""
    for number in range(60):
        summary = names["drive"](names["SteerAway"](), names["contract"], f"{number}.mcap", 25)
        if summary.verdicts.get("OK"):
            return
    raise AssertionError("the body showed nothing")


def on_port(drive: Any, port: int) -> Any:
    return lambda *args, **more: drive(*args, port=port, **more)


def has_stable_baselines3() -> bool:
    try:
        import stable_baselines3  # noqa: F401  # only whether it is there
    except ModuleNotFoundError:
        return False
    return True
