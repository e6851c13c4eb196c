"""Drives behind a guard: recorded with its settings, and replayed to the bit at both levels."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.cutting.cut import cut
from reflexarc_logs.cutting.span import TickSpan
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from support.policies import exported
from support.recordings import CONTRACT, MS, PERIOD_NS, RUN, START_NS, drive, nominal, retina_at
from support.slices import slice_by_time, times_ns

TICKS = 200
GUARD = GuardSettings(footprint=Footprint(radius_m=0.1), deceleration_mps2=2.0)
GUARDED_RUN = replace(RUN, guard=GUARD.to_json())
ASKED = {"OK", "GUARDED", "STUCK"}


def retinas(seed: int) -> dict[int, list[Message]]:
    """Retinas in which things come near and go again."""
    rng = np.random.default_rng(seed)
    waves = 195 + 55 * np.sin(np.arange(TICKS)[:, None] / 9 + rng.uniform(0, 2.0, 16))
    values = np.clip(waves, 0, 254).astype(np.uint8).reshape(TICKS, *CONTRACT.retina.shape)
    return {slot: [retina_at(slot, values[slot - 1])] for slot in range(1, TICKS, 2)}


def scans(seed: int) -> dict[int, list[Message]]:
    """Scans of 91 beams, one every other slot."""
    rng, schedule = np.random.default_rng(seed), {}
    for slot in range(1, TICKS, 2):
        received_ns = START_NS + slot * PERIOD_NS - 3 * MS
        ranges = 1.0 + 0.9 * np.sin(slot / 9 + rng.uniform(0, 1.5, 91))
        schedule[slot] = [
            Message(
                "robot0/scan",
                LaserScan(start_angle=-1.6, end_angle=1.6, ranges=ranges).SerializeToString(),
                protobuf_encoding("foxglove.LaserScan"),
                pack_stamp(Stamp(slot, received_ns - MS)),
                received_ns,
            )
        ]
    return schedule


def both(seed: int) -> dict[int, list[Message]]:
    """Retinas that say nothing of ranges, and scans of a sensor of its own, which rests a while."""
    schedule = dict(nominal(TICKS, seed))
    for slot, (message,) in scans(seed).items():
        stamp = pack_stamp(Stamp(slot, message.received_ns - MS, b"lidar".ljust(16)))
        if not 80 < slot < 110:
            schedule[slot] = [*schedule[slot], replace(message, attachment=stamp)]
    return schedule


@pytest.fixture(params=["retina", "scan", "both"])
def guarded(request, tmp_path) -> Path:
    run = replace(GUARDED_RUN, input="retina" if request.param == "both" else request.param)
    if request.param == "both":
        run = replace(run, guard=replace(GUARD, ranges="scan").to_json())
    schedule = {"retina": retinas, "scan": scans, "both": both}[request.param](3)
    path = tmp_path / "guarded.mcap"
    verdicts = drive(path, exported(CONTRACT, 2), schedule, TICKS, run=run)
    assert min(verdicts[name] for name in ASKED) > 5
    return path


def test_a_guarded_drive_replays_identically_at_both_levels(guarded):
    report = replay(guarded)
    assert report.exit_status == 0, report.lines()
    assert [level.level for level in report.levels] == ["policy", "node"]
    assert all(level.compared == level.identical > 150 for level in report.levels)


def test_other_settings_than_the_recorded_ones_show_at_level_node(guarded, monkeypatch):
    log = read_log(guarded)
    wider = replace(GuardSettings.from_json(log.run.guard), margin_m=0.4)
    changed = replace(log, run=replace(log.run, guard=wider.to_json()))
    report = replay(changed)
    policy, node = report.levels
    assert policy.compared == policy.identical
    assert node.identical < node.compared


def test_a_memory_and_a_hold_go_on_through_a_guarded_drive(tmp_path):
    held = replace(CONTRACT, hold_s=0.1, margin=0.1)
    path = tmp_path / "held.mcap"
    drive(path, exported(held, 2), retinas(5), TICKS, run=GUARDED_RUN)
    decisions = [tick.decision for tick in read_log(path).ticks()]
    assert {d.verdict for d in decisions} >= {Verdict.OK, Verdict.GUARDED, Verdict.STUCK}
    assert replay(path).exit_status == 0


def test_a_part_cut_out_of_a_guarded_drive_replays(guarded, tmp_path):
    part = tmp_path / "part.mcap"
    cut(read_log(guarded), TickSpan(60, 160), part)
    report = replay(part)
    assert report.exit_status == 0, report.lines()
    assert report.levels[-1].level == "node"
    assert report.levels[-1].compared > 20


def test_a_slice_of_another_tool_replays_behind_its_keyframe(guarded, tmp_path):
    first_ns, end_ns = times_ns(guarded)
    middle_ns = first_ns + (end_ns - first_ns) // 4
    report = replay(slice_by_time(guarded, tmp_path / "slice.mcap", middle_ns, end_ns))
    assert report.exit_status == 0, report.lines()
    assert report.levels[-1].level == "node"
    assert report.levels[-1].compared > 90


def test_a_log_of_before_has_no_guard():
    assert RunInfo.from_metadata({"run_id": "1"}).guard == ""
