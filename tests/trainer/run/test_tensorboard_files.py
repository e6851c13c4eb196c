"""Event files: one scalar per column, added to by a resumed run."""

import sys
from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.run.history import Row
from reflexarc_trainer.run.tensorboard_files import event_files

ROWS = [Row(100, 1.0, 0.5, 0.2, 40.0, 9.0), Row(200, 2.0, 0.1, 0.1, 20.0, 7.0)]


def test_without_tensorboard_the_flag_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "torch.utils.tensorboard", None)
    with pytest.raises(UsageError, match=r"pip install 'reflexarc\[tensorboard\]'") as refusal:
        event_files(tmp_path).__enter__()
    assert "\n" not in str(refusal.value)


def test_event_files_hold_every_point_and_a_resumed_run_adds_to_them(tmp_path: Path) -> None:
    reading = pytest.importorskip("tensorboard.backend.event_processing.event_accumulator")
    for row in (ROWS[0], ROWS[1]):
        with event_files(tmp_path) as measured:
            measured(row)
    events = reading.EventAccumulator(str(tmp_path / "tensorboard")).Reload()
    points = events.Scalars("validation_contacts_per_100m")
    assert [(point.step, point.value) for point in points] == [(100, 9.0), (200, 7.0)]
    assert set(events.Tags()["scalars"]) == set(Row._fields) - {"step"}
