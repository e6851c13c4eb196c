"""An incident becomes a log of its own, which shows it and replays."""

import json
from pathlib import Path

import pytest

from reflexarc_logs.cutting.cut import cut
from reflexarc_logs.cutting.incident_part import INCIDENT, choose, cut_incident
from reflexarc_logs.cutting.span import TickSpan
from reflexarc_logs.reading.incidents import Incident, find_incidents
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Body
from support.policies import exported
from support.processes import reflexarc
from support.recordings import CONTRACT, drive, nominal
from support.staged_incidents import body, contact, mark, staged, stopped_between

TICKS = 400


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive that touches something twice, is marked, and is stopped by a hand for a second."""
    folder = tmp_path_factory.mktemp("incidents")
    schedule = nominal(TICKS)
    stopped_between(schedule, 250, 300)
    drive(folder / "plain.mcap", exported(CONTRACT, 3, "Relu"), schedule, TICKS)
    heard = {120: contact(1), 121: contact(2), 200: mark("here it was odd")}
    return staged(folder / "plain.mcap", folder / "drive.mcap", heard)


@pytest.fixture(scope="module")
def log(path: Path) -> Log:
    return read_log(path)


def test_all_that_happens_is_found_and_the_end_of_the_run_is_none(log: Log):
    found = [(one.kind, one.tick, one.words) for one in find_incidents(log)]
    assert found == [
        ("contact", 120, "number 1, at 1.25, -0.50 m"),
        ("contact", 121, "number 2, at 1.25, -0.50 m"),
        ("mark", 200, "here it was odd"),
        ("stop", 249, "a hand"),  # slots count from 1, ticks from 0
    ]


@pytest.mark.parametrize("kind", ["contact", "stop", "mark"])
@pytest.mark.parametrize("narrow", [True, False])
def test_an_incident_becomes_a_log_that_shows_it_and_replays(
    log: Log, kind, narrow: bool, tmp_path: Path
):
    incident = choose(log, None, kind)
    found = cut_incident(log, incident, 2.0, tmp_path / "part.mcap", narrow=narrow)
    assert found.is_shown
    assert found.report.exit_status == 0
    assert [level.level for level in found.report.levels] == ["policy", "node"]
    assert incident in list(find_incidents(read_log(found.part.path)))
    assert read_log(found.part.path).metadata[INCIDENT]["kind"] == kind
    assert found.part.ticks == 201 or narrow  # 2 s on each side, at 50 Hz


def test_the_narrow_part_begins_before_the_choice_that_led_there(log: Log, tmp_path: Path):
    actions = [tick.decision.action for tick in log.ticks()]
    first = 120
    while actions[first - 1] == actions[120]:
        first -= 1
    part = cut_incident(log, choose(log, None, "contact"), 5.0, tmp_path / "part.mcap").part
    assert (part.span.first, part.span.end) == (first - 1, 122)


def test_around_bounds_the_narrow_part(log: Log, tmp_path: Path):
    part = cut_incident(log, choose(log, 200, None), 0.04, tmp_path / "part.mcap").part
    assert (part.span.first, part.span.end) == (198, 202) or part.span.first > 198


def test_any_tick_can_be_chosen_and_none_that_is_not_there(log: Log, tmp_path: Path):
    chosen = choose(log, 77, None)
    assert cut_incident(log, chosen, 1.0, tmp_path / "part.mcap").is_shown
    with pytest.raises(LogError, match="expected a tick 9999"):
        cut_incident(log, choose(log, 9999, None), 1.0, tmp_path / "none.mcap")
    assert not (tmp_path / "none.mcap").exists()


def test_what_did_not_happen_is_not_found(log: Log):
    with pytest.raises(LogError, match="expected guard, found contact, mark, stop"):
        choose(log, None, "guard")


def test_an_incident_of_a_part_is_a_part_too(log: Log, tmp_path: Path):
    wide = cut_incident(log, choose(log, None, "stop"), 3.0, tmp_path / "wide.mcap", narrow=False)
    again = read_log(wide.part.path)
    narrow = cut_incident(again, choose(again, None, "mark"), 1.0, tmp_path / "narrow.mcap")
    assert narrow.is_shown
    assert read_log(narrow.part.path).metadata[INCIDENT]["kind"] == "mark"
    assert narrow.report.exit_status == 0


def test_a_log_without_incidents_and_one_without_ticks(tmp_path: Path):
    quiet = tmp_path / "quiet.mcap"
    drive(quiet, exported(CONTRACT), nominal(30), 30)
    assert list(find_incidents(read_log(quiet))) == []
    with pytest.raises(LogError, match="found none at all"):
        choose(read_log(quiet), None, None)


def test_the_command_lists_and_cuts(path: Path, tmp_path: Path):
    listed = reflexarc("incident", path, "--json")
    kinds = [one["kind"] for one in json.loads(listed.stdout)["incidents"]]
    assert kinds == ["contact", "contact", "mark", "stop"]
    out = tmp_path / "part.mcap"
    made = json.loads(
        reflexarc("incident", path, "--first", "stop", "--around", "1s", "-o", out, "--json").stdout
    )
    assert (made["is_shown"], made["replay"]) == (True, "identical")
    assert reflexarc("replay", out).returncode == 0
    assert reflexarc("incident", path, "--first", "guard", "-o", out).returncode == 2
    assert reflexarc("incident", path, "--around", "long", "-o", out).returncode == 2


def test_an_incident_is_a_value(log: Log):
    assert next(find_incidents(log)) == Incident("contact", 120, _time_of(log, 120), _words(log))


def _time_of(log: Log, index: int) -> int:
    ticks = log.records(log.topic("tick"))
    return next(r.log_ns for n, r in enumerate(ticks) if n == index)


def _words(log: Log) -> str:
    return next(find_incidents(log)).words


@pytest.mark.parametrize("narrow", [True, False])
def test_a_part_knows_what_its_body_said_of_itself(path: Path, tmp_path: Path, narrow: bool):
    """Once a second, and so rarely within the part: without it no world can be built again."""
    other = body()[1]
    other.seed = 8  # another world of the same body: the last one counts
    heard = {60: body(), 90: (body()[0], other), 170: body()}
    whole = read_log(staged(path, tmp_path / "drive.mcap", heard))
    incident = choose(whole, None, "contact")
    found = cut_incident(whole, incident, 0.5, tmp_path / "part.mcap", narrow=narrow)
    said = list(read_log(found.part.path).messages("/robot0/body", Body))
    assert [message for _, message in said] == [other]
    (before,) = [r for r, m in whole.messages("/robot0/body", Body) if m == other]
    assert (said[0][0].log_ns, said[0][0].sequence) == (before.log_ns, before.sequence)
    assert found.report.exit_status == 0
    assert found.is_shown


def test_a_part_from_the_beginning_has_it_once(path: Path, tmp_path: Path):
    whole = read_log(staged(path, tmp_path / "drive.mcap", {0: body()}))
    part = cut(whole, TickSpan(0, 30), tmp_path / "part.mcap")
    assert len(list(read_log(part.path).records("/robot0/body"))) == 1
