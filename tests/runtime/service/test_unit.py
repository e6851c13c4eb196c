import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.service.unit import ServiceUnit

UNIT = ServiceUnit("robot0", ("/usr/bin/true", "run", "--config", "/etc/reflexarc/robot0.toml"))
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
        replace(UNIT, networked=True, realtime_priority=50, user="root"),
        replace(UNIT, writes=(Path("/var/log/a robot"), Path("/srv/100%"))),
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
    unit = replace(UNIT, networked=networked, systemd_version=252)
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


def test_a_folder_that_it_writes_to_is_absolute():
    with pytest.raises(UsageError, match="--writes"):
        replace(UNIT, writes=(Path("logs"),))
