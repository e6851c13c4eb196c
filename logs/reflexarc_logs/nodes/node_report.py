"""What a node says of a log beside what was recorded, for a reader who opens nothing else."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from reflexarc_logs.diffing.diff_report import DiffReport, FieldDiff, FirstAt, TopicDiff
from reflexarc_logs.diffing.diff_rules import FieldTolerance
from reflexarc_runtime.words.suggestion import pasteable

UPDATE = "--reflexarc-update"
_SHOWN = 8


@dataclass(frozen=True)
class NodeReport:
    """One node on one log."""

    path: str
    node: str
    topic: str
    first_ns: int
    """Log time of the log's first message."""
    fed: Mapping[str, int]
    others: Mapping[str, int]
    diff: DiffReport
    """A: recorded, B: the node's words."""
    tolerances: tuple[FieldTolerance, ...]
    """Those that were allowed on the topic."""
    rules: str = ""
    """The file with the rules; empty: there is none."""
    was_cut: bool = False

    @property
    def is_same(self) -> bool:
        """Whether it said what was recorded."""
        return self.diff.exit_status == 0

    @property
    def found(self) -> TopicDiff | None:
        """The comparison of its topic; None: neither side has a message."""
        return next(iter(self.diff.topics), None)

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> Iterator[str]:
        """What differs, where first, by how much, and what to do."""
        yield f"{self.path}: {self.node} on {self.topic}: {self._verdict()}"
        yield f"  fed with {_counts(self.fed)}"
        found = self.found
        if found is not None:
            yield from self._differences(found)
        if self.others:
            yield f"  not compared, as it is not its topic: {_counts(self.others)}"
        if self.was_cut:
            yield "  the log is cut: what there is of it was compared"
        if not self.is_same:
            yield from self._next(found)

    def summary(self) -> str:
        """One line."""
        return f"{self.path}: {self.node} on {self.topic}: {self._verdict()}"

    def _verdict(self) -> str:
        found = self.found
        if found is None:
            return "nothing was recorded and nothing is said: nothing to compare"
        if not found.messages_a:
            return f"{found.messages_b} messages, and none was recorded"
        if not found.messages_b:
            return f"it says nothing, and {found.messages_a} messages were recorded"
        if found.is_same:
            return f"{found.identical} messages, the same as recorded"
        return f"{found.identical} of {found.paired} messages are as recorded"

    def _differences(self, found: TopicDiff) -> Iterator[str]:
        if not (found.messages_a and found.messages_b):
            return
        yield (
            f"  recorded {found.messages_a}, said {found.messages_b}, "
            f"paired by {found.align.replace('-', ' ')} {found.paired}"
        )
        if found.first is not None:
            yield f"  first divergence: {self._where(found.first)}"
        for whose, count, first in (
            ("recorded", found.only_a, found.first_only_a),
            ("said", found.only_b, found.first_only_b),
        ):
            if first is not None:
                yield f"  only {whose}: {count}, the first {self._where(first)}"
        for one in list(found.fields.values())[:_SHOWN]:
            yield f"  {_field(one.field)}: {self._margin(one)}"
        if len(found.fields) > _SHOWN:
            yield f"  … and {len(found.fields) - _SHOWN} more fields"

    def _where(self, at: FirstAt) -> str:
        place = f"message {at.number}, {(at.log_ns - self.first_ns) * 1e-9:.3f} s into the log"
        return f"{place}: {_field(at.path)}: recorded {at.a}, said {at.b}" if at.a else place

    def _margin(self, one: FieldDiff) -> str:
        apart = "" if one.largest is None else f", by {one.largest:.4g} at most"
        allowed = [t for t in self.tolerances if t.fields.cover(one.field)]
        said = " or ".join(
            f"{t.absolute:g}" + f" + {t.relative:g} of it" * bool(t.relative) for t in allowed
        )
        return f"{one.differences} differ{apart}; allowed {said or '0'}"

    def _next(self, found: TopicDiff | None) -> Iterator[str]:
        if found is None:
            return
        yield "  next:"
        command = pasteable("pytest", self.path, UPDATE)
        yield f"    {command}   records anew what the node says, by hand"
        numbers = [one for one in found.fields.values() if one.largest is not None]
        if numbers:
            place = self.rules or "a file that `reflexarc_node_rules` names"
            yield f"    or allow it, in {place}:"
            for one in numbers[:_SHOWN]:
                field = f'fields = "{self.topic}:{one.field}"'
                yield f"      [[tolerate]]\n      {field}\n      absolute = {one.largest:.4g}"


def _field(path: str) -> str:
    """What a field is called; a message of JSON may be a number by itself."""
    return path or "the value"


def _counts(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{n} of {topic}" for topic, n in sorted(counts.items())[:_SHOWN])
