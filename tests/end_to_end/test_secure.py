"""A robot behind a door, with real processes; every other door is tried."""

import json
import signal
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import SecurityFolder, make_folder
from reflexarc.securing.variants import settings_of
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from support.processes import finished, reflexarc, said_line, started, wait_for_records


@pytest.fixture
def folder(tmp_path: Path, port: int) -> SecurityFolder:
    return make_folder(tmp_path / "keys", SecuredRobot("robot0", (), port, "body", 1.0))


def opened(folder: SecurityFolder, path: tuple[str, ...], value: object) -> None:
    """Spoil one setting of the door."""
    settings = settings_of(folder, "body")
    inner = settings
    for part in path[:-1]:
        inner = inner[part]
    inner[path[-1]] = value
    folder.file("body").write_text(json.dumps(settings))


def checked(folder: SecurityFolder, *words: object) -> tuple[int, dict[str, str]]:
    done = reflexarc("secure", "check", folder.path, "--json", *words)
    doors = json.loads(done.stdout)["doors"]
    return done.returncode, {each["door"]: each["state"] for each in doors}


def test_a_guest_says_why_it_cannot_join(folder: SecurityFolder, tmp_path: Path, port: int):
    """A door that is not there yet, and one of another authority."""
    other = make_folder(tmp_path / "other", SecuredRobot("robot0", (), port, "body", 1.0))
    absent = reflexarc("stop", "--zenoh", folder.file("operator"))
    assert absent.returncode == 2
    assert "nobody listens there" in absent.stderr
    with started("record", "--zenoh", folder.file("recorder"), "-o", tmp_path / "r.mcap") as early:
        said_line(early, "waiting for it")
        log = Path("tests/golden/nominal.mcap").resolve()
        with started("play", log, "--loop", "--zenoh", folder.file("body")):
            wait_for_records(tmp_path / "r.mcap", "retina", 5, 40.0)
            foreign = reflexarc("stop", "--zenoh", other.file("operator"))
        early.send_signal(signal.SIGINT)
        assert early.wait(30.0) == 0
    assert foreign.returncode == 2
    [line] = foreign.stderr.splitlines()
    assert "authority" in line
    assert "secure init" in line


@pytest.mark.long
def test_every_door_of_a_folder_is_shut(folder: SecurityFolder):
    status, doors = checked(folder)
    assert set(doors.values()) == {"shut"}
    assert status == 0
    assert {"plain TCP", "an expired certificate", "viewer says nothing", "who asks"} <= set(doors)


@pytest.mark.long
@pytest.mark.parametrize(
    ("path", "value", "door"),
    [
        (("access_control", "default_permission"), "allow", "viewer says nothing"),
        (("access_control", "enabled"), False, "nobody says nothing"),
        (("transport", "link", "tls", "enable_mtls"), False, "an expired certificate"),
    ],
)
def test_a_door_that_is_open_is_found(
    path: tuple[str, ...], value: object, door: str, folder: SecurityFolder
):
    """The proof that the trials can fail."""
    opened(folder, path, value)
    status, doors = checked(folder)
    assert status == 1
    assert doors[door] == "OPEN"


@pytest.mark.long
def test_a_robot_is_driven_stopped_logged_and_replayed_behind_its_door(
    folder: SecurityFolder, policy: Path, tmp_path: Path, port: int
):
    log, listened = tmp_path / "drive.mcap", tmp_path / "listened.mcap"
    driving = ("--no-guard", "--record", log, "--zenoh", folder.file("runtime"), "--json")
    with (
        started("sim", "--zenoh", folder.file("body"), "--json", cwd=tmp_path) as body,
        started("run", policy, *driving, cwd=tmp_path) as loop,
        ExitStack() as stack,
    ):
        wait_for_records(log, "retina", 100, 60.0)
        listening = started("record", "--zenoh", folder.file("recorder"), "-o", listened)
        recorder = stack.enter_context(listening)  # it asks for the policy when it begins
        status, doors = checked(folder, "--connect", f"tls/127.0.0.1:{port}")
        assert set(doors.values()) == {"shut"}
        assert doors["viewer at the robot in use"] == "shut"
        assert status == 0
        denied = reflexarc("stop", "--zenoh", folder.file("viewer"))
        assert denied.returncode == 1
        time.sleep(0.5)
        stopped = reflexarc("stop", "--zenoh", folder.file("operator"))
        assert stopped.returncode == 0, stopped.stderr
        finished(loop, signal.SIGINT)
        recorder.send_signal(signal.SIGINT)
        assert recorder.wait(30.0) == 0
        assert finished(body, signal.SIGINT)["distance_m"] > 0.5
    assert replay(log).exit_status == 0
    assert replay(listened).exit_status == 0
    assert list(read_log(log).records("/robot0/stop"))
