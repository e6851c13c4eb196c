"""Real lidar logs through the real commands: import, play, run, record, replay."""

import signal
from pathlib import Path

import pytest

from reflexarc.main import main
from reflexarc_logs.importing.lidar_import import import_log
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.decision import Verdict
from support.lidar import CARMEN, carmen_file
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started, wait_for_records

LIVE = "seattle"
"""The smallest one is played in real time; the others in lockstep, which is faster."""


@pytest.fixture(scope="module")
def lidar_policy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    contract = PolicyContract(
        retina=RetinaSpec(rays=16, fov_rad=3.14, range_m=5.0), max_input_age_s=0.5
    )
    path = tmp_path_factory.mktemp("lidar") / "policy.onnx"
    path.write_bytes(exported(contract, seed=11))
    return path


def verdicts_while_scanning(log: Log) -> list[int]:
    """Verdicts of the ticks between the first scan and the last one."""
    times = [record.log_ns - log.run.wall_offset_ns for record in log.records("/robot0/scan")]
    ticks = [tick.decision for tick in log.ticks()]
    return [t.verdict for t in ticks if times[0] <= t.now_ns <= times[-1] and t.verdict != 7]


def check(path: Path) -> None:
    log = read_log(path)
    verdicts = verdicts_while_scanning(log)
    assert verdicts.count(Verdict.OK) > 0.95 * len(verdicts)
    report = replay(log)
    assert report.exit_status == 0, report.lines()
    assert {level.level for level in report.levels} == {"policy", "node"}


@pytest.mark.parametrize("name", [name for name in CARMEN if name != LIVE])
def test_a_real_log_drives_a_policy_in_lockstep_and_replays_to_the_bit(
    lidar_policy: Path, port: int, tmp_path: Path, name: str
):
    scans, drive = tmp_path / "scans.mcap", tmp_path / "drive.mcap"
    count = import_log(carmen_file(name), scans, "carmen").scans
    words = (
        "run",
        lidar_policy,
        "--no-guard",
        "--input",
        "scan",
        "--lockstep",
        "--record",
        drive,
        "--json",
    )
    with (
        started(*words, "--port", port) as runtime,
        started("play", scans, "--lockstep", "--port", port, "--json") as body,
    ):
        played = finished(body)
        finished(runtime, signal.SIGINT)
    log = read_log(drive)
    assert played["messages"]["scan"] == count
    assert [tick.decision.input.sequence for tick in log.ticks()][:-1] == list(range(count))
    original = [r.payload for r in read_log(scans).records("/robot0/scan")]
    assert [r.payload for r in log.records("/robot0/scan")] == original
    check(drive)


@pytest.mark.long
def test_a_real_log_drives_a_policy_in_real_time_and_replays_to_the_bit(
    lidar_policy: Path, port: int, tmp_path: Path
):
    scans, drive = tmp_path / "scans.mcap", tmp_path / "drive.mcap"
    done = reflexarc("import", "carmen", carmen_file(LIVE), "-o", scans)
    assert done.returncode == 0, done.stderr
    assert "241 in 24.0 s" in done.stdout
    words = (
        "run",
        lidar_policy,
        "--no-guard",
        "--input",
        "scan",
        "--record",
        drive,
        "--port",
        port,
        "--json",
    )
    with started(*words) as runtime:
        said_line(runtime, "reflexarc run:")
        with started("play", scans, "--speed", 5, "--port", port, "--json") as body:
            played = finished(body)
        finished(runtime, signal.SIGINT)
    assert played["messages"] == {"scan": 241, "pose": 241, "tf": 241, "odometry": 240}
    assert (played["loops"], played["undecodable"]) == (1, 0)
    log = read_log(drive)
    assert {f"/robot0/{name}" for name in played["messages"]} < {r.topic for r in log.records()}
    check(drive)


def test_a_loop_goes_on_with_its_numbers_until_it_is_ended(
    lidar_policy: Path, port: int, tmp_path: Path
):
    scans, heard = tmp_path / "scans.mcap", tmp_path / "heard.mcap"
    text = "".join(f"FLASER 3 1 2 3 0 0 0 0 0 0 {k} host {k}\n" for k in range(5))
    (tmp_path / "five.log").write_text(text)
    import_log(tmp_path / "five.log", scans, "carmen", rate=100.0)
    with (
        started("record", "-o", heard, "--port", port, "--json") as recorder,
        started("play", scans, "--loop", "--port", port, "--json") as body,
    ):
        wait_for_records(heard, "scan", 40)
        played = finished(body, signal.SIGINT)
        finished(recorder, signal.SIGINT)
    records = list(read_log(heard).records("/robot0/scan"))
    numbers = [record.sequence for record in records]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert played["loops"] == played["messages"]["scan"] // 5
    assert [r.publish_ns for r in records] == sorted({r.publish_ns for r in records})


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["play", "none.mcap"], "cannot be read"),
        (["play", "text.log"], "expected an MCAP file"),
        (["play", "scans.mcap", "--speed", "0"], "--speed"),
        (["play", "scans.mcap", "--speed", "nan"], "--speed"),
        (["play", "scans.mcap", "--speed", "2", "--lockstep"], "--speed"),
        (["import", "carmen", "none", "-o", "o.mcap"], "cannot be read"),
        (["import", "carmen", "scans.mcap", "-o", "o.mcap"], "binary"),
        (["import", "coreslam", "text.log", "-o", "o.mcap"], "expected a coreslam log"),
        (["import", "carmen", "text.log", "-o", "scans.mcap"], "exists"),
        (["import", "carmen", "text.log", "-o", "o.mcap", "--rate", "0"], "--rate"),
        (["import", "carmen", "text.log", "-o", "o.mcap", "--rate", "x"], "--rate"),
        (["import", "carmen", "text.log", "-o", "o.mcap", "--rate", "recorded"], "line 2"),
        (["import", "carmen", "text.log", "-o", "o.mcap", "--robot", "a/b"], "--robot"),
        (["import", "kitti", "text.log", "-o", "o.mcap"], "kitti"),
    ],
)
def test_wrong_use_is_said_in_one_line_and_leaves_nothing(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    expected: str,
):
    line = "FLASER 3 1 2 3 0 0 0 0 0 0 7 host 7\n"
    (tmp_path / "text.log").write_text(line * 2)
    import_log(tmp_path / "text.log", tmp_path / "scans.mcap", "carmen")
    monkeypatch.chdir(tmp_path)
    assert exit_status(words) == 2
    said = capsys.readouterr().err.strip()
    assert expected in said
    assert len(said.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scans.mcap", "text.log"]


def exit_status(words: list[str]) -> object:
    try:
        return main(words)
    except SystemExit as end:
        return end.code
