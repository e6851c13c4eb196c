"""Every command that waits says after a while for what, on which key, and what it hears instead."""

import signal
from pathlib import Path

import pytest

from reflexarc_runtime.ros2.ros_types import LASER_SCAN
from reflexarc_sim_bridge.body.ros2.wires import RmwWire, Ros2DdsWire
from support.processes import Process, reflexarc, said_line, started
from support.ros2_drives import FAST_ENOUGH
from support.ros2_robot import robot
from support.witness import body, runtime


def line_of(process: Process, number: signal.Signals | None = signal.SIGINT) -> str:
    """The line about the silence, after which the command ends in good order."""
    line = said_line(process, "waits for")
    if number is not None:
        process.send_signal(number)
        process.communicate(timeout=30.0)
        assert process.returncode == 0
    return line.strip()


@pytest.mark.long
@pytest.mark.parametrize("lockstep", [(), ("--lockstep",)])
def test_run_without_a_body(policy: Path, port: int, lockstep: tuple[str, ...]):
    with started("run", policy, "--port", port, *lockstep) as loop:
        line = line_of(loop)
    awaited = "a body that listens on robot0/command" if lockstep else "retinas on robot0/retina"
    assert line == (
        f"reflexarc run: waits for {awaited}; nobody answers at tcp/127.0.0.1:{port} "
        "(is the body started? another --port?)"
    )


@pytest.mark.long
@pytest.mark.parametrize(
    "words", [(), ("--policy",), ("--lockstep",), ("--policy", "--lockstep")], ids=" ".join
)
def test_sim_without_a_runtime(policy: Path, port: int, tmp_path: Path, words: tuple[str, ...]):
    given = [word for flag in words for word in (flag, *[policy] * (flag == "--policy"))]
    with started("sim", *given, "--port", port, cwd=tmp_path) as process:
        line = line_of(process)
    awaited = "commands on robot0/command" if "--policy" in words else "a runtime on robot0/policy"
    assert line == (
        f"reflexarc sim: waits for {awaited}; nobody has joined at tcp/127.0.0.1:{port} "
        "(is it started? with another --port?)"
    )


@pytest.mark.long
def test_what_is_heard_instead_and_what_to_do(policy: Path, port: int, tmp_path: Path):
    log = tmp_path / "a.mcap"
    with body(policy, port, tmp_path):
        with started("run", policy, "--port", port, "--robot", "rover") as loop:
            line = line_of(loop)
            assert "waits for retinas on rover/retina; hears robot0/retina (" in line
            assert line.endswith("instead: another robot, --robot robot0?")
        with started("run", policy, "--port", port, "--input", "scan") as loop:
            line = line_of(loop)
            assert "waits for scans on robot0/scan; hears robot0/retina (" in line
            assert line.endswith("instead: --input retina")
        with started("record", "-o", log, "--port", port, "--robot", "rover") as record:
            line = line_of(record)
            assert "waits for messages on rover/…; hears robot0/" in line
            assert line.endswith("instead: another robot, --robot robot0?")
        done = reflexarc("arm", "--port", port, "--robot", "rover", "--patience", 1)
        assert done.returncode == 1
        assert "no body of rover answered within 1 s; hears robot0/" in done.stderr
        assert done.stderr.endswith("instead: another robot, --robot robot0?\n")


@pytest.mark.long
def test_an_operator_with_patience_is_told_meanwhile(port: int):
    with started("stop", "--port", port, "--patience", 60) as process:
        line = said_line(process, "waits for")
    assert line.startswith("reflexarc stop: waits for a body on robot0/lease; nobody answers")


@pytest.mark.long
def test_a_body_beside_another_robot_s_runtime(policy: Path, port: int, tmp_path: Path):
    rover = ("--port", port, "--robot", "rover")
    with started("run", policy, *rover), started("sim", "--port", port, cwd=tmp_path) as process:
        line = line_of(process)
    assert "waits for a runtime on robot0/policy; hears rover/tick (" in line
    assert line.endswith("instead: another robot, --robot rover?")


@pytest.mark.long
def test_play_in_lockstep_waits_for_its_runtime(policy: Path, port: int):
    log = Path(__file__).parents[1] / "golden" / "nominal.mcap"
    with started("play", log, "--lockstep", "--port", port) as process:
        line = line_of(process)
    assert "reflexarc play: waits for commands on robot0/command; nobody has joined" in line


def test_when_all_is_well_nothing_is_said(policy: Path, port: int, tmp_path: Path):
    with body(policy, port, tmp_path) as process, runtime(policy, port, tmp_path) as loop:
        log = tmp_path / "a.mcap"
        record = reflexarc("record", "-o", log, "--port", port, "--seconds", 5)
        for one in (loop, process):
            one.send_signal(signal.SIGINT)
            _, complaint = one.communicate(timeout=30.0)
            assert "waits for" not in complaint
    assert record.returncode == 0
    assert "waits for" not in record.stderr


@pytest.mark.long
@pytest.mark.parametrize("wire", ["ros2dds", "rmw"])
def test_a_bridge_says_which_flag_would_hear_the_robot(port: int, tmp_path: Path, wire: str):
    """A robot of the other kind scans beside it: the line names the flag."""
    other = {"ros2dds": RmwWire(7), "rmw": Ros2DdsWire()}[wire]
    words = ("--wire", wire, "--port", port, *FAST_ENOUGH)
    with (
        robot(port, other.key("/scan", LASER_SCAN), "cmd_vel", stamped=False),
        started("ros2", *words, cwd=tmp_path) as bridge,
    ):
        line = said_line(bridge, "waits for scans")
    assert {"ros2dds": "--wire rmw --domain 7?", "rmw": "--wire ros2dds?"}[wire] in line
