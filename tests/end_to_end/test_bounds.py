"""Whoever would move by a policy that asks for too much refuses it, until a flag allows it."""

import signal
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action, sideways_actions
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started

USUAL = PolicyContract()
BEYOND = {
    "creeping": (replace(USUAL, safe_command=Action("creep", 0.1, 0.0)), ["--allow-moving-stop"]),
    "racing": (replace(USUAL, actions=sideways_actions(30.0)), ["--max-speed-mps", "30"]),
    "endless": (replace(USUAL, actions=sideways_actions(1e308)), ["--max-speed-mps", "inf"]),
    "patient": (replace(USUAL, max_input_age_s=3600.0), ["--max-wait-s", "3600"]),
}
"""A contract, and the flag that it needs."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("beyond")
    for name, (contract, _) in BEYOND.items():
        (folder / f"{name}.onnx").write_bytes(exported(contract))
    return folder


def refusal(*words: object) -> str:
    """The one line with which a command ends with status 2, after what it waits for."""
    done = reflexarc(*words)
    assert done.returncode == 2, done.stderr
    *notices, line = done.stderr.splitlines()
    assert all("waiting for a runtime" in notice for notice in notices)
    return line


@pytest.mark.parametrize("name", BEYOND)
def test_run_and_sim_refuse_it_and_name_the_flag(folder: Path, port: int, name: str):
    policy, flag = folder / f"{name}.onnx", BEYOND[name][1][0]
    assert flag in refusal("run", policy, "--ticks", 3, "--port", port)
    assert flag in refusal("sim", "--policy", policy, "--steps", 3, "--port", port)


@pytest.mark.parametrize("name", [name for name in BEYOND if name != "endless"])
def test_with_the_flag_both_run_and_a_body_asks_for_its_own(folder: Path, port: int, name: str):
    policy, flags = folder / f"{name}.onnx", BEYOND[name][1]
    with started("run", policy, "--port", port, "--json", *flags) as runtime:
        said_line(runtime, "reflexarc run:")
        # The runtime's flag is the runtime's: what moves has bounds of its own.
        with started("sim", "--port", port) as waiting:  # for another one that it can obey
            assert flags[0] in said_line(waiting, "no policy to build an eye for")
            assert waiting.poll() is None
        with started("sim", "--steps", 3, "--port", port, "--json", *flags) as body:
            assert finished(body)["steps"] == 3
        finished(runtime, signal.SIGINT)


def test_a_speed_that_cannot_be_simulated_runs_and_is_refused_by_the_simulated_body(
    folder: Path, port: int
):
    policy, flags = folder / "endless.onnx", BEYOND["endless"][1]
    with started("run", policy, "--port", port, "--ticks", 3, "--json", *flags) as runtime:
        assert finished(runtime)["ticks"] == 4
    words = ("sim", "--policy", policy, "--steps", 3, "--port", port, *flags)
    assert "m in a step" in refusal(*words)


def test_a_policy_without_a_digest_runs_and_says_so_once(port: int):
    older = Path(__file__).parents[1] / "golden" / "museum" / "schema-2" / "reflex.onnx"
    done = reflexarc("run", older, "--ticks", 3, "--port", port)
    assert done.returncode == 0
    [line] = [line for line in done.stderr.splitlines() if "no digest" in line]
    assert line.startswith("reflexarc run: ")
