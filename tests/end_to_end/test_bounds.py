"""Whoever would move by a policy that asks for too much refuses it, until a flag allows it."""

import signal
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action, sideways_actions
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started
from support.ros2_robot import router

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
    heavy = BodySpec(Footprint(radius_m=0.5), deceleration_mps2=10.0)
    heavy_one = replace(USUAL, actions=sideways_actions(30.0, 0.0), body=heavy)
    (folder / "point.onnx").write_bytes(exported(USUAL))
    (folder / "heavy.onnx").write_bytes(exported(heavy_one))
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


def test_sim_refuses_a_policy_that_learned_with_a_better_body(folder: Path, port: int):
    """World `rover` has a body of 0.2 m with inertia; the policy learned as a point."""
    words = ("sim", "--world", "rover", "--policy", folder / "point.onnx", "--port", port)
    said = refusal(*words)
    assert "it reaches 0.2 m, expected at most 0 m" in said
    assert "--allow-body" in said


def test_ros2_refuses_a_policy_that_learned_with_a_better_body(folder: Path, port: int):
    limits = ("--max-linear", "1", "--max-lateral", "1", "--max-angular", "1")
    with router(port), started("run", folder / "point.onnx", "--port", port) as runtime:
        words = ("ros2", *limits, "--port", port, "--radius", "0.3", "--delay", "0.2")
        said_line(runtime, "reflexarc run:")
        said = refusal(*words)
        assert "it obeys after 0.2 s, expected at most 0 s" in said
        assert "it reaches 0.3 m, expected at most 0 m" in said
        runtime.send_signal(signal.SIGINT)


def test_run_refuses_a_policy_that_cannot_stand_before_what_it_sees(folder: Path, port: int):
    """30 m/s · (0.1 + 0.02 + 0.1) s + 30² / (2 · 10) m = 51.6 m, of 5 m less 0.5 m."""
    words = ("run", folder / "heavy.onnx", "--max-speed-mps", "30", "--ticks", 3, "--port", port)
    said = refusal(*words)
    assert "needs 51.6 m to stand" in said
    assert "sees 4.5 m" in said
    assert "--allow-fast" in said
    done = reflexarc(*words, "--allow-fast")
    assert done.returncode == 0, done.stderr


def test_a_policy_without_a_digest_runs_and_says_so_once(port: int):
    older = Path(__file__).parents[1] / "golden" / "museum" / "schema-2" / "reflex.onnx"
    done = reflexarc("run", older, "--ticks", 3, "--port", port)
    assert done.returncode == 0
    [line] = [line for line in done.stderr.splitlines() if "no digest" in line]
    assert line.startswith("reflexarc run: ")
