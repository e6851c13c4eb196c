"""Where a service records: in folders, so that no start finds its name taken, where it may."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.wiring.keeping_logs.black_box_flags import BlackBoxFlags
from reflexarc.wiring.keeping_logs.recording_flags import RecordingFlags, is_for_folder
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.recording.keeping import Keeping
    from reflexarc_runtime.service.unit import ServiceUnit

STATES = Path("/var/lib")


def check_places(
    record: Path | None, flags: RecordingFlags, box: BlackBoxFlags, unit: "ServiceUnit"
) -> None:
    """Check that a service can record again and again, by the rights that its unit gives.

    Args:
        record: where the whole run goes; None: nowhere.
        flags: how it is kept.
        box: of the black box.
        unit: of the service.

    Raises:
        UsageError: a place is no folder, or it may not write there.
    """
    allowed = (STATES / unit.folder, *unit.writes)
    for flag, place, keeping in _places(record, flags, box):
        if not is_for_folder(place, keeping):
            raise UsageError(
                f"{flag}: expected a folder (a name without .mcap, and rotate-s, rotate-mb or "
                f"keep-mb beside it), got {place}: the second start would find its name taken"
            )
        if not any(Path(os.path.abspath(place)).is_relative_to(folder) for folder in allowed):
            raise UsageError(
                f"{flag}: {place}: the service may write below {allowed[0]} only; record there, "
                "or name a folder with --writes"
            )


def _places(
    record: Path | None, flags: RecordingFlags, box: BlackBoxFlags
) -> Iterator[tuple[str, Path, "Keeping"]]:
    keeping = flags.keeping("reflexarc service")
    if record is not None:
        yield "record", record, keeping
    if box.span is None:
        return
    if box.black_box_out is None:
        raise UsageError("black-box: expected black-box-out beside it: one folder for all starts")
    yield "black-box-out", box.black_box_out, box.keeping(keeping)
