"""How a run went, for a person and for a program."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING

from reflexarc.terminal.output import microseconds

if TYPE_CHECKING:
    from reflexarc.wiring.keeping_logs.outcome import Recording
    from reflexarc_runtime.loop.cadence.monitor import Summary


def summary_as_dict(summary: "Summary", recordings: "Mapping[str, Recording]") -> dict[str, object]:
    """All of it, for `--json`; `recording` is the whole run's, a black box has keys of its own."""
    said: dict[str, object] = dict(asdict(summary))
    for name, recording in recordings.items():
        is_whole = name == "recording"
        said[name.replace(" ", "_")] = recording.in_words
        said["parts" if is_whole else f"{name.replace(' ', '_')}_parts"] = recording.parts
    return said


def summary_in_words(
    summary: "Summary", recordings: "Mapping[str, Recording]"
) -> dict[str, object]:
    """What the table at the end says."""
    return {
        "ticks": summary.ticks,
        "rate": f"{summary.rate_hz:.2f} Hz",
        "lateness": f"p50 {microseconds(summary.lateness_p50_ns)}, "
        f"p99 {microseconds(summary.lateness_p99_ns)}, "
        f"max {microseconds(summary.lateness_max_ns)}",
        "skipped slots": summary.skipped_slots,
        "verdicts": ", ".join(f"{k} {v}" for k, v in summary.verdicts.items()),
        **{name: recording.in_words for name, recording in recordings.items()},
    }
