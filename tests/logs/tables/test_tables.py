import csv
import math
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.tables.csv_table import write_csv
from reflexarc_logs.tables.tick_rows import TickTable
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.codec import encode_contact
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from support.policies import SMALL, exported
from support.recordings import MS, START_NS, drive, nominal

GOLDEN = Path(__file__).parents[2] / "golden"
LOGS = [*sorted(GOLDEN.glob("*.mcap")), *sorted((GOLDEN / "museum").rglob("*.mcap"))]
ACTIONS = ["stay", "left", "right"]

each_log = pytest.mark.parametrize("path", LOGS, ids=lambda path: str(path.relative_to(GOLDEN)))


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@each_log
def test_every_tick_is_a_row_that_says_what_the_log_says(path: Path, tmp_path: Path):
    ticks = list(read_log(path).ticks())
    assert write_csv(read_log(path), tmp_path / "out.csv") == len(ticks)
    for row, tick in zip(read_csv(tmp_path / "out.csv"), ticks, strict=True):
        decision = tick.decision
        assert int(row["tick"]) == decision.index
        assert Verdict[row["verdict"]] == decision.verdict
        assert float(row["linear_mps"]) == decision.command.linear_mps
        assert float(row["lateral_mps"]) == decision.command.lateral_mps
        assert bytes.fromhex(row["retina"]) == decision.retina
        assert row["action_name"] == (["safe", *ACTIONS][decision.action + 1])
        said = [row[f"q_{name}"] for name in ACTIONS]
        assert [as_float32(text) for text in said if text] == list(decision.q_values)


@each_log
def test_parquet_says_the_same_as_csv(path: Path, tmp_path: Path):
    pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    from reflexarc_logs.tables.parquet_table import write_parquet

    write_csv(read_log(path), tmp_path / "out.csv")
    rows = write_parquet(read_log(path), tmp_path / "out.parquet")
    table = pq.read_table(tmp_path / "out.parquet")
    expected = read_csv(tmp_path / "out.csv")
    assert rows == table.num_rows == len(expected)
    for column in TickTable(read_log(path)).columns:
        values = table.column(column.name).to_pylist()
        assert [as_text(column.kind, value) for value in values] == [
            row[column.name] for row in expected
        ]
    about = table.schema.metadata
    assert about[b"reflexarc.policy_hash"].decode() == read_log(path).run.policy_hash


def as_float32(text: str) -> float:
    found: float = struct.unpack("<f", struct.pack("<f", float(text)))[0]
    return found


def as_text(kind: str, value: Any) -> str:
    if value is None:
        return ""
    if kind == "bytes":
        return str(value.hex())
    if kind == "floats":
        return " ".join(f"{number:.9g}" for number in value)
    return f"{value:.9g}" if kind == "float32" else str(value)


def beside() -> Iterator[Message]:
    """A pose and a contact that stand in the log before the first tick."""
    pose = PoseInFrame(frame_id="world")
    pose.pose.position.x, pose.pose.position.y = 1.5, -2.0
    half = math.pi * 0.75  # three quarters of a turn to the left are a quarter to the right
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(half), math.cos(half)
    yield message("pose", "foxglove.PoseInFrame", pose.SerializeToString())
    yield message("contact", "reflexarc.Contact", encode_contact(1, 0.0, 0.0, START_NS))


def message(name: str, schema: str, payload: bytes) -> Message:
    stamp = pack_stamp(Stamp(0, START_NS - MS))
    return Message(f"robot0/{name}", payload, protobuf_encoding(schema), stamp, START_NS)


def test_the_newest_pose_and_the_contacts_so_far_stand_in_the_row(tmp_path: Path):
    drive(tmp_path / "log.mcap", exported(SMALL), nominal(5), 5, before=beside())
    write_csv(read_log(tmp_path / "log.mcap"), tmp_path / "out.csv")
    for row in read_csv(tmp_path / "out.csv"):
        assert (row["x_m"], row["y_m"], row["contacts"]) == ("1.5", "-2.0", "1")
        assert float(row["heading_rad"]) == pytest.approx(-math.pi / 2)


def test_what_is_not_known_is_empty_and_never_zero(tmp_path: Path):
    write_csv(read_log(GOLDEN / "faults.mcap"), tmp_path / "out.csv")
    rows = read_csv(tmp_path / "out.csv")
    first = next(row for row in rows if row["verdict"] == "NO_INPUT")
    unknown = ("winner", "x_m", "input_age_ns", "retina", "q_left", "memory")
    assert [first[name] for name in unknown] == [""] * len(unknown)


def test_what_is_there_is_never_overwritten_and_nothing_half_is_left(tmp_path: Path):
    out = tmp_path / "out.csv"
    out.write_text("mine")
    with pytest.raises(LogError, match="exists already"):
        write_csv(read_log(GOLDEN / "nominal.mcap"), out)
    assert out.read_text() == "mine"
    with pytest.raises(LogError, match="cannot be written"):
        write_csv(read_log(GOLDEN / "nominal.mcap"), tmp_path / "missing" / "out.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]
