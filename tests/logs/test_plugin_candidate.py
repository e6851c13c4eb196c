"""The plugin judges a candidate; its failures need no other file; a baseline is new by hand."""

import shutil
from pathlib import Path

import pytest

from reflexarc_logs.cutting.incident_part import choose, cut_incident
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.messages_pb2 import Decision
from support.plugin_runs import project, run_pytest
from support.policies import exported
from support.recordings import CONTRACT
from support.rewriting import edit_decisions, rewrite
from support.slow_judge import decisions, slow_flips
from support.staged_incidents import contact, staged


@pytest.fixture
def here(log_path: Path, tmp_path: Path) -> Path:
    """A project with a log whose name wants quotes, and a candidate."""
    (tmp_path / "home").mkdir()
    found = project(tmp_path / "home", "reflexarc_logs = golden")
    shutil.copy(log_path, found / "golden/a drive.mcap")
    (found / "new.onnx").write_bytes(exported(CONTRACT, 4, "Relu"))
    return found


def with_ini(here: Path, *lines: str) -> None:
    with (here / "pytest.ini").open("a") as file:
        file.write("".join(f"{line}\n" for line in lines))


def test_a_candidate_is_one_test_a_log_and_its_limits_decide(here):
    flips = slow_flips(here / "golden/a drive.mcap", (here / "new.onnx").read_bytes())
    with_ini(here, "reflexarc_policy = new.onnx", f"reflexarc_max_flips = {len(flips)}")
    passing = run_pytest(here)
    assert passing.returncode == 0, passing.stdout
    assert "golden/a drive.mcap::candidate PASSED" in passing.stdout
    strict = run_pytest(here, "--reflexarc-max-flips", str(len(flips) - 1))
    assert strict.returncode == 1
    assert f"{len(flips)} flips (" in strict.stdout
    window = run_pytest(here, "--reflexarc-max-flips=0", "--reflexarc-from=0", "--reflexarc-to=5")
    assert window.returncode == int(any(one.tick < 5 for one in flips))


def test_a_failure_says_what_was_seen_how_sure_both_were_and_what_to_type(here):
    flips = slow_flips(here / "golden/a drive.mcap", (here / "new.onnx").read_bytes())
    said = run_pytest(here, "--reflexarc-policy", "new.onnx", "--reflexarc-margin=0.01").stdout
    worst = max(flips, key=lambda one: one.margin)
    names = ("stay", "left", "right")
    lead = worst.candidate_q_values[worst.candidate] - worst.candidate_q_values[worst.recorded]
    place = f"tick {worst.tick} ({worst.time_s:.2f} s): "
    change = f"{names[worst.recorded]} → {names[worst.candidate]}"
    line = next(line for line in said.splitlines() if place in line)
    assert change in line
    assert f"margin {worst.margin:.3g}, the candidate's {lead:.3g}" in line
    retina = decisions(here / "golden/a drive.mcap")[worst.tick].retina
    drawn = "".join(" ░▒▓█"[0 if not v else min(4, 1 + v // 64)] for v in retina)
    assert f"left │{drawn}│ right" in said
    command = "reflexarc replay 'golden/a drive.mcap' --policy new.onnx --margin 0.01"
    assert f"next: {command}" in said
    assert "Traceback" not in said


def test_a_failure_of_the_software_shows_the_moment_and_the_note_of_its_incident(here, log_path):
    whole = staged(log_path, here / "whole.mcap", {30: contact(1)})
    log = read_log(whole)
    part = here / "part.mcap"
    cut_incident(log, choose(log, None, "contact"), 2.0, part)
    (here / "golden/a drive.mcap").unlink()

    def turned(decision: Decision) -> None:
        if decision.index == 30:
            decision.winner = decision.action = (decision.winner + 1) % 3

    rewrite(part, here / "golden/changed.mcap", edit_decisions(turned))
    said = run_pytest(here).stdout
    first = decisions(part)[0].now_ns
    at = next(one for one in decisions(part) if one.index == 30)
    assert "first divergence: tick 30" in said
    assert "it shows contact at tick 30 of whole.mcap: number 1, at 1.25, -0.50 m" in said
    assert f"tick 30 ({(at.now_ns - first) / 1e9:.2f} s) saw" in said
    values = sorted(at.q_values)
    assert f"by {values[2] - values[1]:.3g}; now " in said
    assert "next: reflexarc replay golden/changed.mcap" in said
    assert "if this is meant: pytest golden/changed.mcap --reflexarc-update" in said


@pytest.mark.parametrize("workers", [(), ("-p", "xdist", "-n", "2")], ids=["alone", "xdist"])
def test_a_baseline_is_new_only_by_the_flag_and_old_and_new_are_shown(workers, here, log_path):
    log = here / "golden/a drive.mcap"
    policy = ("--reflexarc-policy", "new.onnx")
    assert run_pytest(here, *policy).returncode == 1
    assert log.read_bytes() == log_path.read_bytes()
    done = run_pytest(here, *policy, "--reflexarc-update", *workers)
    assert done.returncode == 0, done.stdout
    assert "reflexarc: new baselines" in done.stdout
    assert "\ngolden/a drive.mcap: " in done.stdout
    assert "\n  old: sha256 " in done.stdout
    assert "ticks are decided otherwise" in done.stdout
    assert replay(log).policy_hash == read_log(log).run.policy_hash
    assert run_pytest(here, *policy).returncode == 0
    assert run_pytest(here).returncode == 0


@pytest.mark.parametrize(
    ("ini", "words", "complaint"),
    [
        ("", ("--reflexarc-max-flips=5%",), "--reflexarc-max-flips: limits judge a candidate"),
        ("addopts = --reflexarc-update", (), "--reflexarc-update: by hand only"),
        ("reflexarc_policy = gone.onnx", (), "reflexarc_policy: gone.onnx: there is no such file"),
        ("reflexarc_policy = new.onnx\nreflexarc_max_flips = 5 %%", (), "--max-flips: expected"),
        ("reflexarc_policy = new.onnx\nreflexarc_margin = small", (), "--margin: expected numbers"),
    ],
)
def test_options_that_cannot_be_meant_are_refused_before_any_test(ini, words, complaint, here):
    with_ini(here, ini)
    done = run_pytest(here, *words)
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert complaint in done.stderr


def test_limits_in_the_ini_file_wait_for_a_policy(here):
    with_ini(here, "reflexarc_max_flips = 0", "reflexarc_margin = 0.5")
    assert "golden/a drive.mcap::replay PASSED" in run_pytest(here).stdout
