"""What a diff found: as data, as text, as Markdown."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

SHOWN_FIELDS = 8
_SHOWN_CHARACTERS = 60


@dataclass(frozen=True)
class FirstAt:
    """The first message at which something was seen."""

    number: int
    """Counted from 0 among the pairs of its topic."""
    sequence: int
    log_ns: int
    """Of the side that has it; of A, if both have."""
    path: str = ""
    """The field, with its index in lists."""
    a: str = ""
    b: str = ""


@dataclass
class FieldDiff:
    """One field of one topic, over all its messages."""

    field: str
    """Without indices of lists."""
    differences: int = 0
    largest: float | None = None
    """How far two numbers lay apart at most; None: they are no numbers."""
    first: FirstAt | None = None


@dataclass
class TopicDiff:
    """One topic of both files."""

    topic: str
    type_name: str
    align: str
    messages_a: int
    messages_b: int
    paired: int = 0
    identical: int = 0
    """Pairs that are equal under the rules."""
    only_a: int = 0
    only_b: int = 0
    first_only_a: FirstAt | None = None
    first_only_b: FirstAt | None = None
    fields: dict[str, FieldDiff] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def is_same(self) -> bool:
        """Whether nothing differs and nothing is missing."""
        return self.identical == self.paired and not self.only_a and not self.only_b

    @property
    def first(self) -> FirstAt | None:
        """The first message at which the two sides are not the same."""
        found = [f.first for f in self.fields.values() if f.first is not None]
        found += [f for f in (self.first_only_a, self.first_only_b) if f is not None]
        return min(found, key=lambda at: at.number, default=None)


@dataclass(frozen=True)
class DiffReport:
    """What a diff found."""

    a: str
    b: str
    topics: tuple[TopicDiff, ...]
    ignored: tuple[str, ...] = ()
    """Topics that the rules pass over."""
    notes: tuple[str, ...] = ()

    @property
    def exit_status(self) -> int:
        """0: the same under the rules. 1: different. 2: nothing was compared."""
        if any(not topic.is_same for topic in self.topics):
            return 1
        return 0 if any(topic.paired for topic in self.topics) else 2

    @property
    def verdict(self) -> str:
        """The exit status in words."""
        return ("the same", "different", "nothing was compared")[self.exit_status]

    @property
    def first(self) -> tuple[TopicDiff, FirstAt] | None:
        """Where the two files part for the first time."""
        found = [(t, t.first) for t in self.topics if t.first is not None]
        return min(found, key=lambda pair: pair[1].log_ns, default=None)

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`."""
        head = {"verdict": self.verdict, "exit_status": self.exit_status}
        return {**head, **dataclasses.asdict(self)}

    def lines(self) -> list[str]:
        """A text for people."""
        return list(self._lines())

    def _lines(self) -> Iterator[str]:
        yield f"A {self.a}"
        yield f"B {self.b}"
        yield self.verdict
        if self.first is not None:
            topic, at = self.first
            yield f"first divergence: {topic.topic}, {_where(at)}"
        for topic in self.topics:
            yield from _topic_lines(topic)
        if self.ignored:
            yield f"passed over: {', '.join(self.ignored)}"
        for note in self.notes:
            yield f"note: {note}"

    def markdown(self) -> str:
        """A table, for a comment on a change."""
        head = [f"**{self.verdict}**: A `{self.a}`, B `{self.b}`", ""]
        if self.first is not None:
            topic, at = self.first
            head += [f"First divergence: `{topic.topic}`, {_where(at)}", ""]
        rows = ["| topic | A | B | paired | identical | only A | only B | fields that differ |"]
        rows += ["|---|--:|--:|--:|--:|--:|--:|---|"]
        rows += [_row(topic) for topic in self.topics]
        notes = [f"- {note}" for note in self.notes]
        return "\n".join([*head, *rows, *(["", *notes] if notes else [])])


def _topic_lines(topic: TopicDiff) -> Iterator[str]:
    what = "the same" if topic.is_same else "different"
    yield (
        f"  {topic.topic}: {what}; {topic.messages_a} and {topic.messages_b} messages, "
        f"{topic.paired} paired by {topic.align}, {topic.identical} identical"
    )
    for side, count, first in (
        ("A", topic.only_a, topic.first_only_a),
        ("B", topic.only_b, topic.first_only_b),
    ):
        if first is not None:
            yield f"    only in {side}: {count}, the first {_where(first)}"
    for one in list(topic.fields.values())[:SHOWN_FIELDS]:
        yield f"    {_field_line(one)}"
    if len(topic.fields) > SHOWN_FIELDS:
        yield f"    … and {len(topic.fields) - SHOWN_FIELDS} more fields"
    for note in topic.notes:
        yield f"    note: {note}"


def _field_line(one: FieldDiff) -> str:
    apart = "" if one.largest is None else f", at most {one.largest:.4g} apart"
    first = "" if one.first is None else f"; first {_where(one.first)}"
    return f"{one.field}: {one.differences} differ{apart}{first}"


def _where(at: FirstAt) -> str:
    place = f"message {at.number} (sequence {at.sequence}, {at.log_ns / 1e9:.3f} s)"
    return f"{place}: {at.path}: {at.a} → {at.b}" if at.path else place


def _row(topic: TopicDiff) -> str:
    fields = "; ".join(f"`{f.field}` {f.differences}" for f in topic.fields.values()) or "–"
    counts = (topic.messages_a, topic.messages_b, topic.paired, topic.identical)
    cells = [*counts, topic.only_a, topic.only_b]
    return f"| `{topic.topic}` | {' | '.join(map(str, cells))} | {fields} |"


def shown(value: object) -> str:
    """A value in a report: on one line, and not longer than one."""
    text = repr(value)
    if len(text) > _SHOWN_CHARACTERS:
        text = f"{text[:_SHOWN_CHARACTERS]}…"
    return text
