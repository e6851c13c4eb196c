from pathlib import Path

import numpy as np

from reflexarc_logs.diffing.diff import USUAL_RULES, diff
from reflexarc_logs.recording.recorder import Recorder
from support.recordings import RUN, WALL_OFFSET_NS, retina_at, smooth_retinas


def recorded(path: Path, slots: range, wall_offset_ns: int) -> Path:
    """Retinas whose numbers tell nothing, so that only when they were sent does."""
    retinas = smooth_retinas(slots.stop)
    with Recorder(path, RUN, b"", {}, wall_offset_ns=wall_offset_ns) as recorder:
        for slot in slots:
            recorder.put(retina_at(slot, np.asarray(retinas[slot]), sequence=0))
    return path


def test_two_recordings_of_one_run_pair_by_when_a_message_was_sent_whatever_the_wall_clock_says(
    tmp_path: Path,
):
    """Each measures the wall clock for itself, and the second one heard the first retinas not."""
    a = recorded(tmp_path / "a.mcap", range(20), WALL_OFFSET_NS)
    b = recorded(tmp_path / "b.mcap", range(5, 20), WALL_OFFSET_NS + 1_234)
    report = diff(a, b, USUAL_RULES)
    said = "\n".join(report.lines())
    assert "15 paired by publish-time, 15 identical" in said
