"""Logs with one thing amiss each: it is found, named, and nothing else is."""

import json
import shutil
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.writer import Writer

from reflexarc_logs.checking.check import check
from reflexarc_logs.checking.check_logs import check_logs
from reflexarc_logs.checking.check_report import CheckReport
from reflexarc_runtime.messages_pb2 import Decision
from support import hostile_logs
from support.foreign_logs import json_log
from support.policies import exported
from support.recordings import CONTRACT, FAULT_STALLS, drive, nominal
from support.rewriting import edit_decisions, rewrite

MS = 1_000_000
S = 1_000 * MS


def found_in(path: Path) -> list[tuple[str, str, str]]:
    return [(f.kind, f.severity, f.words) for f in check(path).findings]


def the_one_in(path: Path) -> tuple[str, str, str]:
    [one] = found_in(path)
    return one


def flip(source: Path, target: Path, at: int) -> Path:
    data = bytearray(source.read_bytes())
    data[at] ^= 0x10
    target.write_bytes(data)
    return target


def test_a_whole_drive_is_sound(log_path: Path) -> None:
    found = check(log_path)
    assert (found.verdict, found.replay, found.ticks) == ("sound", "identical", 61)
    assert found.sensor is not None
    assert found.sensor.topic == "/robot0/retina"
    assert found.sensor.period_s == pytest.approx(0.02, rel=0.01)
    assert found.sensor.longest_silence_s == pytest.approx(0.02)


def test_a_log_that_was_never_finished(log_path: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(log_path.read_bytes()[:-40_00])
    kind, severity, words = found_in(cut)[0]
    assert (kind, severity) == ("completeness", "error")
    assert "never finished" in words
    assert "reflexarc recover" in words


def test_every_flipped_bit_is_an_error(log_path: Path, tmp_path: Path) -> None:
    size = log_path.stat().st_size
    for at in range(9, size, size // 40):
        found = check(flip(log_path, tmp_path / f"{at}.mcap", at))
        assert found.refusal or found.count("error"), at


def test_an_attachment_whose_bytes_changed(log_path: Path, tmp_path: Path) -> None:
    """Written without a CRC of all data, as many tools do, an attachment has its own."""
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_attachment(0, 0, "map.png", "image/png", b"a map of the hall")
        number = writer.register_channel("/p", "json", 0)
        for k in range(30):
            writer.add_message(number, k * MS, b"{}", k * MS, k)
        writer.finish()
    assert found_in(path) == []
    at = path.read_bytes().index(b"hall")
    assert the_one_in(flip(path, tmp_path / "y.mcap", at)) == (
        "bytes",
        "error",
        "the CRC of attachment map.png does not fit",
    )


def test_ticks_that_are_missing(log_path: Path, tmp_path: Path) -> None:
    def without(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic.endswith("/tick") and 20 <= nth < 23 else payload

    path = rewrite(log_path, tmp_path / "less.mcap", without)
    assert ("completeness", "error", "3 ticks are missing, from tick 20 on") in found_in(path)


def test_a_loop_that_ended_without_its_stop(log_path: Path, tmp_path: Path) -> None:
    def without(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic.endswith("/tick") and nth == 60 else payload

    path = rewrite(log_path, tmp_path / "short.mcap", without)
    assert "it ends before its loop did" in the_one_in(path)[2]


@pytest.mark.parametrize(
    ("said", "kind", "severity", "words"),
    [
        ({"reflexarc.end": {"dropped": "7"}}, "completeness", "error", "7 records were dropped"),
        ({"reflexarc.end": {"left_out": "4"}}, "completeness", "warning", "4 messages of others"),
        ({"reflexarc.end": {"damaged_chunks": "1"}}, "completeness", "error", "1 chunks were"),
        ({"reflexarc.part": {"lost": "9"}}, "completeness", "error", "9 records were lost before"),
        ({"reflexarc.run": {"policy_hash": "ab" * 32}}, "contract", "error", "attached policy is"),
        ({"reflexarc.run": {"clock": "moon"}}, "contract", "error", "reflexarc.run.clock"),
    ],
)
def test_what_a_log_says_of_itself(
    said: dict[str, dict[str, str]],
    kind: str,
    severity: str,
    words: str,
    log_path: Path,
    tmp_path: Path,
) -> None:
    found = found_in(rewrite(log_path, tmp_path / "said.mcap", metadata=said))
    assert any(f[:2] == (kind, severity) and words in f[2] for f in found), found


def test_a_policy_that_is_no_longer_the_one_that_was_sealed(log_path: Path, tmp_path: Path) -> None:
    broken = {"policy.onnx": exported(CONTRACT, seed=4, activation="Relu")[:-30]}
    found = found_in(rewrite(log_path, tmp_path / "x.mcap", attachments=broken))
    assert any(f[0] == "contract" and "not intact" in f[2] for f in found), found


def test_a_log_without_a_policy_is_said_to_have_none(log_path: Path, tmp_path: Path) -> None:
    bare = {"policy.onnx": None}
    said = {"reflexarc.run": {"policy_hash": ""}}
    path = rewrite(log_path, tmp_path / "x.mcap", attachments=bare, metadata=said)
    assert the_one_in(path)[:2] == ("contract", "warning")


def test_a_decision_that_was_changed(log_path: Path, tmp_path: Path) -> None:
    def sideways(decision: Decision) -> None:
        decision.command.lateral_mps += 1

    path = rewrite(log_path, tmp_path / "changed.mcap", edit_decisions(sideways))
    kind, severity, words = the_one_in(path)
    assert (kind, severity) == ("replay", "error")
    assert "tick 0, command.lateral_mps" in words
    assert "`reflexarc replay" in words


def test_a_loop_that_overslept_and_a_sensor_that_fell_silent(policy: bytes, tmp_path: Path) -> None:
    schedule = nominal(300)
    for slot in range(100, 110):
        schedule[slot] = []
    drive(tmp_path / "x.mcap", policy, schedule, 297, stalls=FAULT_STALLS)
    found = found_in(tmp_path / "x.mcap")
    assert {f[:2] for f in found} == {("gaps", "warning")}
    text = "\n".join(f[2] for f in found)
    assert "deadlines of the loop were skipped, the first before tick 2" in text
    assert "/robot0/retina silent for 220.0 ms (11 periods of 20.0 ms)" in text
    assert "/robot0/retina 10" in text  # by their numbers


def foreign(path: Path, rows: list[tuple[int, int, int]]) -> Path:
    """A log of JSON messages: sequence, time of sending, log time."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        number = writer.register_channel("/scan", "json", 0)
        for sequence, sent_ns, log_ns in rows:
            writer.add_message(number, log_ns, b"{}", sent_ns, sequence)
        writer.finish()
    return path


def regular(count: int) -> list[tuple[int, int, int]]:
    return [(0, S + k * 100 * MS, S + k * 100 * MS + 2 * MS) for k in range(count)]


def test_a_sound_log_of_another_system_has_no_contract_and_no_replay(tmp_path: Path) -> None:
    found = check(foreign(tmp_path / "x.mcap", regular(300)))
    assert (found.verdict, found.replay, found.is_ours) == ("sound", "", False)


@pytest.mark.parametrize(
    ("change", "severity", "words"),
    [
        (lambda k, row: (0, row[1], row[2] - 5 * S * (k >= 150)), "error", "log time goes back"),
        (lambda k, row: (0, row[1] + 7 * S * (k >= 150), row[2]), "warning", "clocks step"),
        (lambda k, row: (0, row[1] + k * 100_000, row[2]), "warning", "clocks drift"),
        (lambda k, row: (0, row[1] + 60 * S * (k >= 150), row[2] + 60 * S * (k >= 150)),
         "warning", "nothing at all for 60"),
    ],
)  # fmt: skip
def test_clocks_that_are_set_and_that_drift(
    change: Callable[[int, tuple[int, int, int]], tuple[int, int, int]],
    severity: str,
    words: str,
    tmp_path: Path,
) -> None:
    rows = [change(k, row) for k, row in enumerate(regular(300))]
    found = found_in(foreign(tmp_path / "x.mcap", rows))
    assert any(f[1] == severity and words in f[2] for f in found), found


def test_the_drift_is_told_in_parts_in_a_million(tmp_path: Path) -> None:
    rows = [(0, sent + k * 100_000, log) for k, (_, sent, log) in enumerate(regular(300))]
    assert "/scan +1000 ppm" in the_one_in(foreign(tmp_path / "x.mcap", rows))[2]


def test_a_topic_that_comes_now_and_then_has_no_gap(tmp_path: Path) -> None:
    rows = [(k, int(1.3**k * MS), {}) for k in range(60)]
    regular_rows = [(k, k * 20 * MS, {}) for k in range(300)]
    assert found_in(json_log(tmp_path / "x.mcap", event=rows[:30], scan=regular_rows)) == []


@pytest.mark.parametrize("content", [b"", b"no log at all", b"\x89MCAP"])
def test_what_is_no_log_cannot_be_read(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    assert check(path).verdict == "unreadable"
    assert CheckReport.of([check(path)]).exit_status == 2


def test_the_worst_is_first_and_the_status_is_that_of_the_worst(
    log_path: Path, tmp_path: Path
) -> None:
    for name in ("b", "a"):
        shutil.copy(log_path, tmp_path / f"{name}.mcap")
    rewrite(log_path, tmp_path / "e.mcap", metadata={"reflexarc.end": {"dropped": "7"}})
    rewrite(log_path, tmp_path / "w.mcap", metadata={"reflexarc.end": {"left_out": "7"}})
    sound = check_logs([tmp_path / "a.mcap"], 1)
    report = check_logs(sorted(tmp_path.glob("*.mcap")), 1)
    assert [Path(log.path).stem for log in report.logs] == ["e", "w", "a", "b"]
    assert (sound.exit_status, report.exit_status) == (0, 1)
    missing = check_logs([tmp_path / "a.mcap", tmp_path / "none.mcap"], 1)
    assert missing.exit_status == 2
    assert missing.logs[0].path.endswith("none.mcap")


def test_any_number_of_processes_gives_the_same_bytes(log_path: Path, tmp_path: Path) -> None:
    for number in range(3):
        shutil.copy(log_path, tmp_path / f"{number}.mcap")
    (tmp_path / "x.mcap").write_bytes(b"?")
    paths, done = sorted(tmp_path.glob("*.mcap")), list[tuple[int, int]]()
    alone = check_logs(paths, 1)
    crew = check_logs(paths[::-1], 2, lambda *both: done.append(both))
    assert json.dumps(alone.as_dict()) == json.dumps(crew.as_dict())
    assert done == [(1, 4), (2, 4), (3, 4), (4, 4)]


SLOW = ("million", "hide their size", "2 GiB")


def patient(name: str) -> object:
    is_slow = any(word in name for word in SLOW)
    return pytest.param(name, marks=pytest.mark.long) if is_slow else name


@pytest.mark.parametrize("name", [*map(patient, (*hostile_logs.BYTES, *hostile_logs.FILES))])
def test_a_hostile_file_is_found_out(name: str, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    if name in hostile_logs.BYTES:
        path.write_bytes(hostile_logs.BYTES[name]())
    else:
        hostile_logs.FILES[name](path)
    found = check(path)
    assert found.refusal or found.count("error")


def test_a_file_that_holds_less_than_its_own_statistics_say(tmp_path: Path) -> None:
    path = foreign(tmp_path / "x.mcap", regular(40))
    data = bytearray(path.read_bytes())
    statistics = data.rindex(struct.pack("<BQ", 11, 4 + 42 + 10)) + 9
    assert struct.unpack_from("<Q", data, statistics) == (40,)
    struct.pack_into("<Q", data, statistics, 45)
    footer = len(data) - 8 - 20
    [begin] = struct.unpack_from("<Q", data, footer)
    struct.pack_into("<I", data, footer + 16, zlib.crc32(data[begin : footer + 16]))
    path.write_bytes(data)
    words = "40 messages, but by its own statistics 45"
    assert the_one_in(path) == ("completeness", "error", words)
