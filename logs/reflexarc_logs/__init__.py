"""REMEMBERS: recorder, reader, replay, comparison and the pytest plugin.

Each public name is loaded from its module when it is first used, so that the pytest plugin costs
nothing to those who have no logs. Two functions are named as their modules are, and are imported
from there: `reflexarc_logs.replaying.replay.replay`, `reflexarc_logs.reading.recover.recover`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reflexarc_logs.container.run_info import RunInfo
    from reflexarc_logs.reading.reader import Log, read_log
    from reflexarc_logs.reading.recover import Recovered
    from reflexarc_logs.reading.summary import LogSummary, summarise
    from reflexarc_logs.recording.recorder import Recorder
    from reflexarc_logs.replaying.report import ReplayReport

__all__ = [
    "Log",
    "LogSummary",
    "Recorder",
    "Recovered",
    "ReplayReport",
    "RunInfo",
    "read_log",
    "summarise",
]

_HOMES = {
    "Log": "reading.reader",
    "Recorder": "recording.recorder",
    "Recovered": "reading.recover",
    "ReplayReport": "replaying.report",
    "RunInfo": "container.run_info",
    "LogSummary": "reading.summary",
    "read_log": "reading.reader",
    "summarise": "reading.summary",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
