"""The page's own lines: its two nodes are tests, on a bag of ROS 2 and on a log of JSON."""

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from support.foreign_logs import json_log
from support.node_projects import run_pytest, write_project
from support.scan_bags import STORE, scans, write_bag

PAGE = (Path(__file__).parents[2] / "docs" / "anyones-node.md").read_text()
CONTROLLER, GOVERNOR = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
OF_BAGS, OF_DRIVES, TOLERANCES = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
[FAILURE] = re.findall(r"^```\n(.*?)^```", PAGE.partition("## When it fails")[2], re.DOTALL | re.M)
MS = 1_000_000


@pytest.mark.parametrize("example", [CONTROLLER, GOVERNOR + OF_DRIVES + TOLERANCES])
def test_an_example_has_under_thirty_lines(example: str) -> None:
    assert len(example.splitlines()) < 30


def plain_twist(scan: Any) -> tuple[float, float]:
    """What the page's controller makes of a scan, beam by beam."""
    beams = [min(max(float(x), 0.0), 10.0) if x == x else 0.0 for x in scan.ranges.tolist()]
    third, half = len(beams) // 3, (len(beams) + 1) // 2
    right, left = sum(beams[:half]) / half, sum(beams[half:]) / (len(beams) - half)
    return 0.5 * min(1.0, *beams[third:-third]), (left - right) / 10.0


def test_the_controller_on_a_bag_of_ros_2(tmp_path: Path) -> None:
    here = write_project(tmp_path, OF_BAGS, hall__controller=CONTROLLER)
    seen = scans(40)
    (here / "bags").mkdir()
    bag = write_bag(here / "bags/hall", seen, plain_twist)
    rounded = run_pytest(here, "bags")
    assert rounded.returncode == 1
    assert re.search(r"angular.z: \d+ differ, by [\d.]+e-0[789] at most", rounded.stdout)
    assert "linear.x:" not in rounded.stdout

    update = run_pytest(here, "bags", "--reflexarc-update")
    assert update.returncode == 0, update.stdout
    assert "recorded anew: bags/hall/hall.mcap: hall.controller:Controller" in update.stdout
    assert twists_in(bag) == [pytest.approx(plain_twist(scan), abs=1e-6) for scan in seen]

    again = run_pytest(here, "bags")
    assert again.returncode == 0, again.stdout
    name = "bags/hall/hall.mcap::/cmd_vel of hall.controller:Controller"
    assert f"{name} PASSED" in again.stdout
    assert "1 passed" in again.stdout

    changed = CONTROLLER.replace("min(1.0, ahead)", "min(0.9, ahead)")
    write_project(here, OF_BAGS, hall__controller=changed)
    failed = run_pytest(here, "bags")
    assert failed.returncode == 1
    assert FAILURE in failed.stdout


def twists_in(bag: Path) -> list[tuple[float, float]]:
    with bag.open("rb") as file:
        found = list(make_reader(file).iter_messages(["/cmd_vel"]))
    assert {schema.name for schema, _, _ in found if schema} == {"geometry_msgs/msg/Twist"}
    twists: list[Any] = [
        STORE.deserialize_cdr(m.data, "geometry_msgs/msg/Twist") for *_, m in found
    ]
    return [(twist.linear.x, twist.angular.z) for twist in twists]


def test_the_governor_on_a_log_of_json(tmp_path: Path) -> None:
    here = write_project(tmp_path, OF_DRIVES, nodes__governor=GOVERNOR)
    (here / "tolerances.toml").write_text(TOLERANCES)
    (here / "drives").mkdir()
    json_log(here / "drives/a.mcap", **governed(count=100, off_mps=3e-7))
    passed = run_pytest(here, "drives")
    assert passed.returncode == 0, passed.stdout
    assert "2 passed" in passed.stdout
    json_log(here / "drives/b.mcap", **governed(count=100, off_mps=3e-6))
    failed = run_pytest(here, "drives")
    assert failed.returncode == 1
    assert "/speed: 1 of 100 messages are as recorded" in failed.stdout
    assert "mps: 99 differ, by 3e-06 at most; allowed 1e-06" in failed.stdout


def governed(count: int, off_mps: float) -> dict[str, list[tuple[int, int, Any]]]:
    """Wanted speeds and distances at 20 Hz, and what a governor recorded, off by a little."""
    times_ns = [(1 + k) * 50 * MS for k in range(count)]
    wanted = [1.0 if k % 40 < 30 else -0.5 for k in range(count)]
    near = [20 <= k // 2 % 35 < 25 for k in range(count)]
    speeds = [0.0]
    for (before, now), want, is_near in zip(pairwise(times_ns), wanted[1:], near[1:], strict=True):
        most = (now - before) * 1e-9
        goal = 0.0 if is_near else want
        speeds.append(max(min(goal, speeds[-1] + most), speeds[-1] - most))
    rows = list(zip(times_ns, wanted, near, speeds, strict=True))
    range_rows, wanted_rows, speed_rows, near_rows = [], [], [], []
    for k, (at, want, is_near, speed) in enumerate(rows):
        range_rows.append((k, at - 1, {"metres": 0.3 if is_near else 2.0}))
        wanted_rows.append((k, at, {"mps": want}))
        speed_rows.append((k, at + MS, {"mps": speed + off_mps * (k > 0)}))
        near_rows.append((k, at + MS, {"near": is_near}))
    return {"range": range_rows, "wanted": wanted_rows, "speed": speed_rows, "near": near_rows}
