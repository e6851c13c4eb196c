import json
from pathlib import Path

import pytest

from reflexarc.main import main
from reflexarc_logs.reading.reader import read_log
from support.ros2 import laser_scan
from support.ros2_bags import START_NS, write_bag

NOMINAL = Path(__file__).parents[3] / "golden" / "nominal.mcap"


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    scan = laser_scan([1.0, 0.0, 3.0]).serialize()
    times = (START_NS + k * 50_000_000 for k in range(5))
    rows = [("/front", "sensor_msgs/msg/LaserScan", at_ns, scan) for at_ns in times]
    return write_bag(tmp_path / "bag", rows)


def test_a_bag_becomes_a_log_and_the_driver_is_understood(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["import", "ros2bag", str(bag), "-o", str(tmp_path / "log.mcap"), "--robot", "rover"]
    assert main([*words, "--no-return", "zero", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["messages"] == {"/rover/scan": 5}
    assert said["became"] == {"/front": "/rover/scan"}
    assert read_log(tmp_path / "log.mcap").run.recorded_by == "import"


def test_what_only_a_bag_has_is_refused_elsewhere(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["-o", str(tmp_path / "log.mcap")]
    assert main(["import", "carmen", str(bag), *out, "--scan", "/front"]) == 2
    assert "for ros2bag only" in capsys.readouterr().err
    assert main(["import", "ros2bag", str(bag), *out, "--rate", "20"]) == 2
    assert "a bag keeps its own times" in capsys.readouterr().err


def test_a_log_becomes_a_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "ros2bag", str(NOMINAL), "-o", str(tmp_path / "bag"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["messages"] == {"/cmd_vel": 301, "/retina": 300}
    assert (tmp_path / "bag" / "metadata.yaml").is_file()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["ros2bag"], "expected a log behind it"),
        (["rosbag", "some.mcap"], "expected ros2bag"),
        (["nothing.npz"], "nothing.npz"),
    ],
)
def test_what_cannot_be_exported_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], complaint: str
) -> None:
    assert main(["export", *words, "-o", str(tmp_path / "out")]) == 2
    assert complaint in capsys.readouterr().err


def test_a_log_becomes_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out.csv"
    assert main(["export", "csv", str(NOMINAL), "-o", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ticks"] == 301
    assert out.read_text().startswith("tick,slot,time_ns,")
