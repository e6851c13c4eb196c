"""What makes a black box write: something happened that a person would look at."""

from collections.abc import Callable

from foxglove_schemas_protobuf.Log_pb2 import Log

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.loop.node import END_OF_RUN
from reflexarc_runtime.messages.topics import CONTACT, MARK, TICK, topic_of
from reflexarc_runtime.messages_pb2 import Contact, Decision, Tick

_BEGINNING = (Verdict.NO_INPUT, Verdict.STALE_INPUT)
"""How every run begins; no news before the policy has driven for the first time."""
_SHOWN = 100


class Triggers:
    """Looks at the entries of a run in their order."""

    def __init__(self) -> None:
        self._verdict = Verdict.OK
        self._has_driven = False
        self._tick = 0

    def look(self, entry: LogEntry) -> str:
        """What happened with this entry, in words; empty if nothing did."""
        topic = topic_of(entry.key)
        if topic is None or entry.kind is not topic.message:
            return ""
        if topic is TICK:
            return self._of_tick(Tick.FromString(entry.payload).decision)
        read = _READ.get(topic.name)
        return f"{read(entry.payload)} (tick {self._tick})" if read is not None else ""

    def _of_tick(self, decision: Decision) -> str:
        """The beginning of a verdict other than OK. The stop that ends every run is none, and
        recovering is no news.
        """
        self._tick, verdict = decision.index, Verdict(decision.verdict)
        before, self._verdict = self._verdict, verdict
        self._has_driven = self._has_driven or verdict is Verdict.OK
        is_start = not self._has_driven and verdict in _BEGINNING
        is_end = verdict is Verdict.STOPPED and END_OF_RUN in decision.reason
        if verdict in (before, Verdict.OK, Verdict.RECOVERING) or is_start or is_end:
            return ""
        name = verdict.name.lower().replace("_", " ")
        return f"{name}: {decision.reason[:_SHOWN]} (tick {decision.index})"


def _contact(payload: bytes) -> str:
    return f"contact {Contact.FromString(payload).count}"


def _mark(payload: bytes) -> str:
    return f"mark: {Log.FromString(payload).message[:_SHOWN]}"


_READ: dict[str, Callable[[bytes], str]] = {CONTACT.name: _contact, MARK.name: _mark}
