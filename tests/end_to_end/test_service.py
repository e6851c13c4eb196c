"""`reflexarc run` as a service, under a manager that follows its unit."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from campaigns.deaths.booted import BootedSystemd, can_boot
from campaigns.deaths.leftovers import leftovers
from campaigns.deaths.replayed import replayed
from campaigns.deaths.robot import Robot
from campaigns.deaths.services import followed_service, systemd_service
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.service.unit import ServiceUnit
from support.plain_body import plain_body
from support.policies import exported
from support.processes import reflexarc, started, wait_until
from support.service_life import Life
from support.supervisor import Supervisor


@contextmanager
def served(policy: Path, port: int, folder: Path) -> Iterator[Supervisor]:
    """A body, and a service that drives and records it."""
    words = ("run", policy, "--no-guard", "--port", port, "--record", "logs", "--rotate-s", 60)
    command = (sys.executable, "-m", "reflexarc", *map(str, words))
    unit = ServiceUnit("robot0", command, watchdog_s=5.0)
    with plain_body(PolicyContract(), port), Supervisor(unit.text(), folder) as service:
        wait_until(lambda: service.lives and service.lives[-1].ready_s, "the first tick")
        yield service


def test_it_is_ready_is_fed_by_its_ticks_and_says_that_it_ends(
    policy: Path, port: int, tmp_path: Path
):
    with served(policy, port, tmp_path) as service:
        (life,) = service.lives
        wait_until(lambda: life.fed_s > (life.ready_s or 0.0), "a feeding")
        wait_until(lambda: life.said == "STATUS=OK", "how it fares")
    assert (life.cause, life.status) == ("stop", 0)
    assert life.stopping_s is not None
    (log,) = log_paths([tmp_path / "logs"])
    assert replay(log).exit_status == 0


@pytest.fixture
def secured(policy: Path, port: int, tmp_path: Path) -> ServiceUnit:
    """A service behind a door that nobody opens yet, on a machine whose systemd is old."""
    pytest.importorskip("cryptography")
    done = reflexarc("secure", "init", tmp_path / "keys", "--port", port)
    assert done.returncode == 0, done.stderr
    zenoh = tmp_path / "keys" / "runtime.json5"
    command = (sys.executable, "-m", "reflexarc", "run", str(policy), "--no-guard")
    return ServiceUnit("robot0", command, watchdog_s=5.0, zenoh=zenoh, systemd_version=252)


def waits(service: Supervisor) -> bool:
    return bool(service.lives) and service.lives[-1].said.startswith("STATUS=waiting: ")


@pytest.mark.long
def test_one_that_waits_for_its_door_is_left_alone_and_ends_when_it_is_told(
    secured: ServiceUnit, tmp_path: Path
):
    """Systemd before 254 gives up for ever who ends with status 2."""
    text = re.sub("TimeoutStartSec=.*", "TimeoutStartSec=4", secured.text())
    with Supervisor(text, tmp_path) as service:
        wait_until(lambda: waits(service), "a service that waits")
        wait_until(lambda: time.monotonic() > service.lives[0].began_s + 6.0, "its start is over")
    (life,) = service.lives
    assert (life.cause, life.status, life.ready_s) == ("stop", 0, None)


@pytest.mark.long
def test_a_door_that_opens_late_finds_one_waiting(
    secured: ServiceUnit, policy: Path, tmp_path: Path
):
    with Supervisor(secured.text(), tmp_path) as service:
        wait_until(lambda: waits(service), "a service that waits")
        words = ("sim", "--policy", policy, "--zenoh", tmp_path / "keys" / "body.json5")
        with started(*words, cwd=tmp_path):
            wait_until(lambda: service.lives[-1].ready_s, "the first tick")
    assert [one.status for one in service.lives] == [0]


@pytest.mark.long
def test_one_that_the_manager_ends_says_where_it_was_and_records_again(
    policy: Path, port: int, tmp_path: Path
):
    with served(policy, port, tmp_path) as service:
        (life,) = service.lives
        life.process.send_signal(signal.SIGABRT)
        wait_until(lambda: len(service.lives) > 1 and service.lives[1].ready_s, "the next life")
        time.sleep(0.2)
    assert [one.status for one in service.lives] == [-signal.SIGABRT, 0]
    said = (tmp_path / "said.txt").read_text()
    assert re.search(r"Fatal Python error: Aborted\n+Stack .*\n +File ", said)
    assert len(list((tmp_path / "logs").glob("*.parts.jsonl"))) == 2
    assert len(list((tmp_path / "logs").glob("*.partial"))) == 1


@pytest.mark.long
def test_a_service_that_dies_comes_back_disarmed_and_leaves_logs(
    port: int, tmp_path: Path, monkeypatch
):
    monkeypatch.setitem(os.environ, "PYTHONPATH", os.environ.get("PYTHONPATH", ""))
    dies_well(Robot(tmp_path, port, 3, followed_service(tmp_path, port, keep_mb=100.0)))


@pytest.mark.long
@pytest.mark.skipif(not can_boot(), reason="needs root, systemd and namespaces")
def test_the_same_under_a_real_systemd(port: int, tmp_path: Path, monkeypatch):
    monkeypatch.setitem(os.environ, "PYTHONPATH", os.environ.get("PYTHONPATH", ""))
    with BootedSystemd(tmp_path / "systemd") as system:
        service = systemd_service(system, tmp_path, port, keep_mb=100.0)
        dies_well(Robot(tmp_path, port, 3, service))


@pytest.mark.long
@pytest.mark.skipif(not can_boot(), reason="needs root, systemd and namespaces")
def test_a_secured_robot_waits_and_drives_under_a_real_systemd(port: int, tmp_path: Path):
    """As a user that systemd makes, who may not read the key; past the limit of a start."""
    pytest.importorskip("cryptography")
    policy = exported(PolicyContract())
    (tmp_path / "policy.onnx").write_bytes(policy)
    with BootedSystemd(tmp_path / "systemd") as system:
        python = system.make_environment()
        place = system.path("/etc/reflexarc")
        (place / "policy.onnx").write_bytes(policy)
        (place / "robot.toml").write_text(SECURED)

        def does(*words: object) -> str:
            done = system.runs(*words)
            assert done.returncode == 0, done.stderr
            return done.stdout

        does(python, "-m", "reflexarc", "secure", "init", "/etc/reflexarc/keys", "--port", port)
        does(python, "-m", "reflexarc", "service", "install", "/etc/reflexarc/robot.toml")
        unit = system.path("/etc/systemd/system/reflexarc-robot0.service")
        unit.write_text(re.sub("TimeoutStartSec=.*", "TimeoutStartSec=8", unit.read_text()))
        does("systemctl", "daemon-reload")
        does("systemctl", "start", "--no-block", unit.name)
        began_s = time.monotonic()
        shown = partial(does, "systemctl", "show", unit.name)
        wait_until(lambda: time.monotonic() > began_s + 10.0, "the limit of a start")
        assert "StatusText=waiting: " in shown()
        shutil.copy(place / "keys" / "body.json5", tmp_path)
        words = ("sim", "--policy", "policy.onnx", "--zenoh", "body.json5")
        with started(*words, cwd=tmp_path):
            wait_until(lambda: "StatusText=OK" in shown(), "a robot that drives")
        does("systemctl", "stop", unit.name)
        said = shown().splitlines()
    assert {"Result=success", "NRestarts=0", "DynamicUser=yes"} <= set(said)


SECURED = """\
policy = "policy.onnx"
no-guard = true
zenoh = "keys/runtime.json5"
"""


def dies_well(robot: Robot) -> None:
    robot.die(4, lambda death: None)
    assert len(robot.deaths) == 4
    assert [one for death in robot.deaths for one in death.failures] == []
    assert replayed(robot.folder / "logs").bad == []


@pytest.mark.long
def test_a_number_that_the_kernel_gives_again_is_not_left_over():
    with subprocess.Popen(["sleep", "60"], process_group=0) as process:
        time.sleep(0.1)
        now_s = time.monotonic()
        of_it = Life(process.pid, now_s - 1.0, ended_s=now_s)
        of_another = Life(process.pid, now_s - 100.0, ended_s=now_s - 50.0)
        assert len(leftovers([of_it])) == 1
        assert leftovers([of_another]) == []
        process.kill()
