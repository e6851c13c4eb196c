"""Logs of queues and of frozen pictures replay, whole and in slices."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from support.policies import exported
from support.recordings import CONTRACT, MS, PERIOD_NS, RUN, drive, retina_at
from support.slices import slice_by_time, times_ns

TICKS = 400
QUEUE = range(200, 260)
FROZEN = range(320, 360)
BEHIND = 100
"""Slots, which are two seconds: while the queue fills, nothing comes."""


def seen_at(slot: int) -> Message:
    """What arrives at a slot: in the queue, what was seen two seconds before."""
    picture = min(slot, FROZEN.start) if slot in FROZEN else slot
    intensities = np.full(CONTRACT.retina.shape, picture % 250, np.uint8)
    jitter_ns = slot * 7919 % 3 * MS
    if slot not in QUEUE:
        message = retina_at(slot, intensities)
        return replace(message, received_ns=message.received_ns - jitter_ns)
    message = retina_at(slot - BEHIND, intensities)
    return replace(message, received_ns=message.received_ns + BEHIND * PERIOD_NS - jitter_ns)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ages") / "drive.mcap"
    schedule = {
        slot: [seen_at(slot)]
        for slot in range(1, TICKS + 1)
        if not QUEUE.start - BEHIND <= slot < QUEUE.start
    }
    run = replace(RUN, senses=SenseSettings(frozen_after_s=0.3).to_json())
    verdicts = drive(path, exported(CONTRACT), schedule, TICKS, run=run)
    assert verdicts["STALE_INPUT"] > 150
    assert verdicts["INVALID_INPUT"] > 20
    assert verdicts["OK"] > 140
    return path


def test_a_queue_and_a_frozen_picture_replay(log: Path):
    report = replay(log)
    assert report.exit_status == 0, report.lines()


def test_so_does_every_slice(log: Path, tmp_path: Path):
    first_ns, end_ns = times_ns(log)
    for number, share in enumerate((0.15, 0.3, 0.45, 0.6, 0.75)):
        begin_ns = first_ns + round(share * (end_ns - first_ns))
        part = slice_by_time(log, tmp_path / f"{number}.mcap", begin_ns, end_ns + 1)
        report = replay(part)
        assert report.exit_status == 0, report.lines()
