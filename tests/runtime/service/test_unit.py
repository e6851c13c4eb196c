import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.service.unit import ServiceUnit

UNIT = ServiceUnit("robot0", ("/usr/bin/true", "run", "--config", "/etc/reflexarc/robot0.toml"))
KEYS = Path("/etc/reflexarc/keys/runtime.json5")
needs_systemd = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed here"
)


def analysed(unit: ServiceUnit, folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    path = folder / unit.name
    path.write_text(unit.text())
    return subprocess.run(
        ["systemd-analyze", *words, str(path)], capture_output=True, text=True, check=False
    )


@needs_systemd
@pytest.mark.parametrize(
    "unit",
    [
        UNIT,
        replace(UNIT, robot="a-b.c"),
        replace(UNIT, zenoh=KEYS, realtime_priority=50, user="root"),
        replace(UNIT, zenoh=Path('/etc/of mine/100%/run"time.json5'), user="1000"),
        replace(UNIT, user="root", writes=(Path("/var/log/a robot"), Path("/srv/100%/a$b"))),
        replace(UNIT, command=("/usr/bin/true", "--config", '/etc/of mine/$HOME %n "x".toml')),
    ],
)
def test_systemd_takes_it_without_a_word(unit, tmp_path):
    done = analysed(replace(unit, systemd_version=252), tmp_path, "verify")
    assert (done.returncode, done.stderr + done.stdout) == (0, "")


@needs_systemd
def test_systemd_takes_what_ends_the_back_off(tmp_path):
    """An older systemd here does not know the steps themselves; they are left out."""
    path = tmp_path / UNIT.name
    kept = [line for line in lines(UNIT) if not line.startswith(("RestartSteps", "RestartMax"))]
    path.write_text("\n".join(kept))
    words = ["systemd-analyze", "verify", str(path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr + done.stdout) == (0, "")


@needs_systemd
@pytest.mark.parametrize(("networked", "worst"), [(False, 1.5), (True, 2.0)])
def test_systemd_finds_it_well_confined(networked, worst, tmp_path):
    unit = replace(UNIT, zenoh=KEYS if networked else None, systemd_version=252)
    done = analysed(unit, tmp_path, "security", "--offline=true", "--no-pager")
    found = re.search(r"Overall exposure level for \S+ ([0-9.]+)", done.stdout)
    assert found is not None
    assert float(found[1]) <= worst


def lines(unit: ServiceUnit) -> list[str]:
    return unit.text().splitlines()


def test_it_waits_longer_after_each_failure_where_systemd_can():
    assert "RestartSteps=8" in lines(replace(UNIT, systemd_version=254))
    assert "RestartSteps=8" not in lines(replace(UNIT, systemd_version=253))


def test_wrong_use_is_tried_again_only_where_that_is_later_each_time():
    assert "RestartPreventExitStatus=2" in lines(replace(UNIT, systemd_version=253))
    assert not any("RestartPrevent" in line for line in lines(UNIT))


def test_a_good_start_ends_the_back_off():
    """Else a service that has died eight times in its life waits for half a minute at each death.

    systemctl(1): reset-failed resets the restart counter of a unit, whatever its state.
    """
    assert "ExecStartPost=-+/usr/bin/systemctl reset-failed reflexarc-robot0.service" in lines(UNIT)


def test_signs_that_systemd_reads_are_doubled():
    unit = replace(UNIT, command=("/usr/bin/true", "$HOME/%n", 'a "b" \\c'))
    assert 'ExecStart=/usr/bin/true $$HOME/%%n "a \\"b\\" \\\\c"' in lines(unit)


@pytest.mark.parametrize("bad", ["a\nExecStartPre=/bin/sh", "a\0b"])
def test_a_path_cannot_add_lines(bad):
    with pytest.raises(UsageError, match="one line"):
        replace(UNIT, command=("/usr/bin/true", bad))


@pytest.mark.parametrize("seconds", [0.0, 0.4, 601.0, float("nan")])
def test_the_managers_patience_has_bounds(seconds):
    with pytest.raises(UsageError, match="--watchdog-s"):
        replace(UNIT, watchdog_s=seconds)


@pytest.mark.parametrize("folder", ["logs", "/srv/../etc", '/srv/a"b', "/srv/a\\b"])
def test_a_folder_that_it_writes_to_is_absolute_and_fits_into_a_list(folder):
    with pytest.raises(UsageError, match="--writes"):
        replace(UNIT, user="robot", writes=(Path(folder),))


def test_a_user_that_systemd_makes_writes_to_no_folder_of_others():
    """ReadWritePaths mounts a folder so that it can be written to; its owner stays its owner."""
    with pytest.raises(UsageError, match="--user NAME"):
        replace(UNIT, writes=(Path("/var/log/robot"),))


@pytest.mark.parametrize("robot", ["a b", "a/../../b", "x\nExecStartPre=+/bin/sh", "", "-x", "%n"])
def test_a_name_cannot_be_more_than_a_name(robot):
    with pytest.raises(UsageError, match="robot: expected letters"):
        replace(UNIT, robot=robot)


@pytest.mark.parametrize("user", ["a b", "root\nExecStartPre=+/bin/sh", "%u", "-1"])
def test_a_user_cannot_be_more_than_a_user(user):
    with pytest.raises(UsageError, match="--user: expected"):
        replace(UNIT, user=user)


def test_the_zenoh_configuration_is_handed_over_to_whoever_may_not_read_it():
    """systemd.exec(5): $CREDENTIALS_DIRECTORY on a command line; %% is a % in a path."""
    said = lines(replace(UNIT, zenoh=Path("/etc/100%/my keys/runtime.json5")))
    assert "LoadCredential=zenoh.json5:/etc/100%%/my keys/runtime.json5" in said
    (start,) = (line for line in said if line.startswith("ExecStart="))
    assert start.endswith("/robot0.toml --zenoh ${CREDENTIALS_DIRECTORY}/zenoh.json5")


def test_a_systemd_that_hands_over_nothing_is_asked_for_nothing():
    text = replace(UNIT, zenoh=KEYS, systemd_version=246).text()
    assert "LoadCredential" not in text
    assert "CREDENTIALS" not in text


@pytest.mark.parametrize("path", ["keys/a.json5", "/etc/../a.json5", "/e/a\\", "/e/a ", "/e\nX"])
def test_a_path_that_a_credential_cannot_have_is_refused(path):
    with pytest.raises(UsageError, match=r"zenoh: expected|one line"):
        replace(UNIT, zenoh=Path(path))


def test_variables_are_read_behind_the_first_word_alone():
    """There `$$` is a `$`; in the path of the program, and in a list of paths, it is two."""
    assert "ReadWritePaths=/srv/a$b" in lines(replace(UNIT, user="a", writes=(Path("/srv/a$b"),)))
    with pytest.raises(UsageError, match="without \\$"):
        replace(UNIT, command=("/opt/a$b/python", "run"))
