"""Cuts a part out of a log: it begins with what the controller knew, so it replays by itself.

The cut is made behind a tick in file order, never by log time: what a tick used stands in front of
it, whatever its time. The keyframe at its beginning is made by replaying all that is cut off. What
a body said of itself and its world, it says once a second: the last of it stands there as well.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from mcap.records import Message

from reflexarc_logs.container.copying import MessageCopier
from reflexarc_logs.container.writing import LogWriter, attachment_of, media_type_of
from reflexarc_logs.cutting.span import TickSpan
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.asked_policy import attached_policy
from reflexarc_logs.replaying.node_level import why_not
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.state_at_tick import KnownState, state_at_tick
from reflexarc_runtime.controller_state import Serving
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.keyframe import encode_state
from reflexarc_runtime.messages.topics import BODY, COMMAND, KEYFRAME, TICK
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy

UNFINISHED = ".cutting"
NOTHING_SAID: Mapping[str, Mapping[str, str]] = {}
CUT = "reflexarc.cut"
"""Metadata of a part: of which log, from which tick to which."""


@dataclass(frozen=True)
class CutReport:
    """What a cut kept."""

    path: Path
    span: TickSpan
    """Which ticks they are: of a slice, from where it tells enough."""
    ticks: int
    messages: int
    has_keyframe: bool
    notes: tuple[str, ...] = ()


def cut(
    log: Log,
    span: TickSpan,
    out: Path | str,
    backend: Backend | str | None = None,
    said: Mapping[str, Mapping[str, str]] = NOTHING_SAID,
) -> CutReport:
    """Write the ticks of a span, and all that stands between them, to a log of its own.

    Args:
        log: the whole log.
        span: which ticks.
        out: the log to be; it must not exist.
        backend: what computes the policy; by default what did when the log was recorded.
        said: metadata of the part, by name, beside what the whole says about itself.

    Raises:
        LogError: the log cannot be read, or `out` cannot be written.
        PolicyError, ContractError: the attached policy is not intact.
    """
    obstacle = why_not(log) if log.policy is not None else "no policy is attached"
    policy = None if obstacle else attached_policy(log, backend)
    served = None if policy is None else ServedPolicies(log, policy)
    known = None if policy is None else state_at_tick(log, policy, span.first)
    if known is not None:
        span = replace(span, first=max(span.first, known.state.index))
    part = _Part(log, span, LogWriter(Path(out), UNFINISHED), said)
    try:
        part.write_head(known, policy, served)
        part.write_ticks()
    except OSError as error:
        part.file.discard()
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing was cut") from None
    except BaseException:
        part.file.discard()
        raise
    notes = [f"it has no keyframe: {obstacle}"] if obstacle else known.notes if known else []
    return CutReport(Path(out), span, part.ticks, part.messages, known is not None, tuple(notes))


class _Part:
    """The part while it is written."""

    def __init__(
        self, log: Log, span: TickSpan, file: LogWriter, said: Mapping[str, Mapping[str, str]]
    ) -> None:
        self.file = file
        self._said = said
        self.ticks = 0
        self.messages = 0
        self._log = log
        self._span = span
        self._copier = MessageCopier(file)
        self._tick = log.topic(TICK.name)
        self._command = log.topic(COMMAND.name)
        self._keyframe = log.topic(KEYFRAME.name)
        self._body = log.topic(BODY.name)
        self._bodies: dict[int, Message] = {}
        """What each body said of itself last before the part begins, by channel."""
        self._is_keyed = False

    def write_head(
        self,
        known: KnownState | None,
        policy: LoadedPolicy | None,
        served: ServedPolicies | None,
    ) -> None:
        """Write what the log says about itself, and what the controller knew."""
        span = {"from": str(self._span.first), "to": str(self._span.end)}
        said = {CUT: {"of": self._log.path.name, **span}, **self._said}
        for name, document in {**self._log.metadata, **said}.items():
            self.file.describe(name, document)
        for name, data in self._log.attachments.items():
            self.file.attach(name, media_type_of(name), data)
        if known is None or policy is None or served is None:
            return
        self._attach_served(known.state.serving, served)
        self.file.add(
            self.file.channel(self._keyframe, KEYFRAME.message),
            encode_state(known.state, policy.policy_hash),
            sequence=known.state.index,
            publish_ns=known.at_ns + self._log.run.publish_shift_ns,
            log_ns=known.at_ns + self._log.run.wall_offset_ns,
        )
        self.messages, self._is_keyed = 1, True

    def _attach_served(self, serving: Serving, served: ServedPolicies) -> None:
        """Attach the policies that took over before the part begins, and may decide in it."""
        for identity in dict.fromkeys((serving.policy_hash, serving.former, serving.pending)):
            name = attachment_of(identity)
            data = served.file_of(identity) if identity else None
            if data is not None and name not in self._log.attachments:
                self.file.attach(name, media_type_of(name), data)

    def write_ticks(self) -> None:
        """Copy what stands in the span, and finish the file."""
        for message in self._between():
            self.messages += self._copier.copy(message)
        if not self.ticks:
            raise LogError(f"{self._log.path}: it has no tick from {self._span.first} on to cut")
        self.file.finish()

    def _between(self) -> Iterator[Message]:
        """What stands behind the tick before the first one, up to the command of the last one."""
        first, end = self._span.first, self._span.end
        inside = first <= next(self._log.ticks()).decision.index  # then all of it belongs
        for message in self._messages():
            topic = self._copier.topic(message)
            index = Tick.FromString(message.data).decision.index if topic == self._tick else None
            if index is not None and index >= end:
                return
            if topic == self._body and not inside:
                self._bodies[message.channel_id] = message
            if inside and self._bodies:
                yield from self._bodies.values()
                self._bodies.clear()
            if inside and not self._is_of_the_tick_before(topic, message):
                self.ticks += index is not None
                yield message
            inside = inside or (index is not None and index >= first - 1)
            if inside and topic == self._command and message.sequence == end - 1:
                return

    def _is_of_the_tick_before(self, topic: str, message: Message) -> bool:
        """Whether it is what the new keyframe replaces, or the command of what was cut off."""
        first = self._span.first
        if topic == self._keyframe:
            return self._is_keyed and message.sequence <= first
        return topic == self._command and message.sequence < first

    def _messages(self) -> Iterator[Message]:
        for record in self._log.mcap_records():
            if isinstance(record, Message):
                yield record
            else:
                self._copier.learn(record)
