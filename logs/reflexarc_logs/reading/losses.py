"""What a recovered log lacks: where, how much, and of which topics."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class LossPlace(StrEnum):
    """Where in the file something is missing, as its messages tell."""

    BEGINNING = "beginning"
    MIDDLE = "middle"
    END = "end"
    UNKNOWN = "somewhere"
    """The log's own statistics count more than there is."""
    BEHIND = "behind the end"
    """After the end of a whole log: not part of it."""


@dataclass(frozen=True)
class LostPart:
    """One part of the file that was not saved."""

    place: LossPlace
    what: str
    """In words: "a damaged chunk"."""
    bytes: int
    messages: int | None
    """How many it held; None: not known."""
    topics: Mapping[str, int]
    """How many of each topic, where that is known."""


@dataclass
class _Lost:
    """A loss before all is known that tells its place."""

    what: str
    bytes: int
    saved_before: int
    place: LossPlace | None
    counts: dict[int, int] | None = None
    """Messages by channel, as the index behind a damaged chunk says."""
    is_open: bool = True
    """Whether the index that follows belongs to it."""


@dataclass
class LossAccount:
    """Adds up what is lost, in the order of the file."""

    _losses: list[_Lost] = field(default_factory=list)

    def add(
        self,
        what: str,
        size: int,
        saved: int,
        place: LossPlace | None = None,
        counts: dict[int, int] | None = None,
    ) -> None:
        """Note a loss; `saved` messages stand before it, and it held these, if that is known."""
        self._losses.append(_Lost(what, size, saved, place, counts))

    def count(self, channel: int, messages: int) -> None:
        """Take in what the index behind the last loss says that it held."""
        if self.waits:
            lost = self._losses[-1]
            counts = lost.counts = lost.counts or {}
            counts[channel] = counts.get(channel, 0) + messages

    @property
    def waits(self) -> bool:
        """Whether an index that comes now tells of the last loss."""
        return bool(self._losses) and self._losses[-1].is_open

    @property
    def first(self) -> str:
        """What was lost first; empty: nothing."""
        return self._losses[0].what if self._losses else ""

    def close(self) -> None:
        """The next chunk comes: what follows tells nothing more of the last loss."""
        if self._losses:
            self._losses[-1].is_open = False

    def losses(
        self,
        saved: Mapping[int, int],
        expected: Mapping[int, int] | None,
        topics: Mapping[int, str],
    ) -> tuple[LostPart, ...]:
        """All losses, now that it is known what was saved.

        Args:
            saved: messages by channel.
            expected: as the log's own statistics say; None: they are lost, too.
            topics: names of the channels.
        """
        if expected is not None:
            self._settle(Counter(expected) - Counter(saved))
        total = sum(saved.values())
        return tuple(_told(lost, total, topics) for lost in self._losses)

    def drop_what_was_index(self) -> None:
        """Forget the parts that could not be read: all records are there, it was an index."""
        self._losses = [lost for lost in self._losses if lost.place]

    def _settle(self, missing: Counter[int]) -> None:
        """Ascribe what the statistics miss to the one loss that does not say what it held."""
        silent = [lost for lost in self._losses if lost.counts is None and not lost.place]
        known = Counter[int]()
        for lost in self._losses:
            known.update(lost.counts or {})
        rest = missing - known
        if len(silent) == 1:
            silent[0].counts = dict(rest)
        elif rest and not silent:
            self.add("missing, by its own statistics", 0, 0, LossPlace.UNKNOWN, dict(rest))
        elif not rest:
            for lost in silent:
                lost.counts = {}


def by_topic(losses: Iterable[LostPart]) -> dict[str, int]:
    """How many messages of each topic are known to be lost."""
    lost: Counter[str] = Counter()
    for loss in losses:
        lost.update(loss.topics)
    return dict(sorted(lost.items()))


def _told(lost: _Lost, total: int, topics: Mapping[int, str]) -> LostPart:
    counts: Counter[str] = Counter()
    for channel, messages in (lost.counts or {}).items():
        counts[topics.get(channel, f"channel {channel}")] += messages
    held = None if lost.counts is None else counts.total()
    return LostPart(_place(lost, total), lost.what, lost.bytes, held, dict(counts))


def _place(lost: _Lost, total: int) -> LossPlace:
    if lost.place is not None:
        return lost.place
    if lost.saved_before == total:
        return LossPlace.END if total else LossPlace.BEGINNING
    return LossPlace.MIDDLE if lost.saved_before else LossPlace.BEGINNING
