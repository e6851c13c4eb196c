"""What a diff passes over, and how far apart values may lie: a small TOML file.

    ignore = ["/robot0/status", "reflexarc.Tick:timing", "*:header.stamp"]

    [[tolerate]]
    fields = "/robot0/tick:decision.q_values"
    absolute = 1e-6

    [align]
    "/scan" = "order"

A pattern names topics or types of messages, and behind a colon fields of theirs; what is inside a
field belongs to it. `*` stands for anything, and indices of lists are left out.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Literal

from reflexarc_logs.diffing.message_file import Stream
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import UsageError

Alignment = Literal["auto", "sequence", "publish-time", "order"]
"""By what the messages of two streams are paired."""

OURS = (
    "reflexarc.Tick:timing",
    "reflexarc.Status",
    "*:command.body",
    "reflexarc.Command:body",
    "*:body.sender",
)
"""How punctual a loop was, and who spoke, is of one run; no two runs agree in it."""


@dataclass(frozen=True)
class Tolerance:
    """How far values of some fields may lie apart: absolute + relative · |value in A|."""

    fields: str
    absolute: float = 0.0
    relative: float = 0.0

    def __post_init__(self) -> None:
        for name in ("absolute", "relative"):
            if not 0.0 <= getattr(self, name) < float("inf"):
                raise UsageError(f"{name}: expected 0 or more, got {getattr(self, name)}")


@dataclass(frozen=True)
class DiffRules:
    """The rules of a diff."""

    ignore: tuple[str, ...] = OURS
    """In a file it takes the place of the usual ones."""
    tolerate: tuple[Tolerance, ...] = ()
    align: Mapping[str, Alignment] = field(default_factory=dict)
    """Pattern of topics → by what their messages are paired; what stands first counts."""

    def ignores(self, stream: Stream) -> bool:
        """Whether a stream is not compared at all."""
        return any(":" not in p and _names(p, stream) for p in self.ignore)

    def ignored_fields(self, stream: Stream) -> "FieldPatterns":
        """Those fields of a stream that are not compared."""
        pairs = (pattern.rpartition(":") for pattern in self.ignore if ":" in pattern)
        return FieldPatterns(tuple(f for topic, _, f in pairs if _names(topic, stream)))

    def tolerances(self, stream: Stream) -> tuple["FieldTolerance", ...]:
        """Those that count for a stream."""
        return tuple(
            FieldTolerance(FieldPatterns((fields,)), one.absolute, one.relative)
            for one in self.tolerate
            for topic, _, fields in [one.fields.rpartition(":")]
            if _names(topic or "*", stream)
        )

    def alignment(self, stream: Stream) -> Alignment:
        """By what the messages of a stream are paired."""
        return next((how for p, how in self.align.items() if _names(p, stream)), "auto")


@dataclass(frozen=True)
class FieldPatterns:
    """Patterns of fields; a pattern covers all that is inside a field."""

    patterns: tuple[str, ...]

    def cover(self, path: str) -> bool:
        """Whether a path like `decision.q_values[3]` is meant."""
        return bool(self.patterns) and _covered(self.patterns, without_indices(path))


@dataclass(frozen=True)
class FieldTolerance:
    """A tolerance for some fields of a stream."""

    fields: FieldPatterns
    absolute: float
    relative: float


def read_rules(path: Path) -> DiffRules:
    """The rules in a file.

    Raises:
        UsageError: it cannot be read, or holds something else.
    """
    return fill(DiffRules, TomlSource(read_text(path, str(path)), str(path)))


@cache
def without_indices(path: str) -> str:
    """`ranges[12].x` → `ranges.x`."""
    return re.sub(r"\[\d+\]", "", path)


@cache
def _covered(patterns: tuple[str, ...], path: str) -> bool:
    return any(fnmatchcase(path, p) or fnmatchcase(path, f"{p}.*") for p in patterns)


def _names(pattern: str, stream: Stream) -> bool:
    topic = stream.topic.partition("#")[0]
    names = (topic, stream.topic, stream.type_name)
    return pattern in names or any(fnmatchcase(name, pattern) for name in names)
