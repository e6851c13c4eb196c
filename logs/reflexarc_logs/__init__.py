"""REMEMBERS: recorder, reader, replay, comparison and the pytest plugin.

Each public name is loaded from its module when it is first used, so that the pytest plugin costs
nothing to those who have no logs. Two functions are named as their modules are, and are imported
from there: `reflexarc_logs.replay.replay`, `reflexarc_logs.recover.recover`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reflexarc_logs.compare import Report
    from reflexarc_logs.reader import Log, read_log
    from reflexarc_logs.recorder import Recorder
    from reflexarc_logs.recover import Recovered
    from reflexarc_logs.run_info import RunInfo
    from reflexarc_logs.summary import Summary, summarise

__all__ = [
    "Log",
    "Recorder",
    "Recovered",
    "Report",
    "RunInfo",
    "Summary",
    "read_log",
    "summarise",
]

_HOMES = {
    "Log": "reader",
    "Recorder": "recorder",
    "Recovered": "recover",
    "Report": "compare",
    "RunInfo": "run_info",
    "Summary": "summary",
    "read_log": "reader",
    "summarise": "summary",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
