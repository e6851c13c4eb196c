"""World files of before, which told times in steps: read for ever as what they meant.

    senses.latency_steps = 3     →  latency_s = 3 dt_s
    senses.gap_steps = 3         →  gap_s = 3 dt_s; 1 is a retina at every step, however long it is
    chassis.slip = 0.2 alone     →  slip_over_s = dt_s

dt_s is the file's own. At steps of that duration such a world has the bits that it always had.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from reflexarc_runtime.config.fill import Resolve, fill
from reflexarc_runtime.config.key_path import KeyPath
from reflexarc_runtime.config.source import Source
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.worlds.checks import require_within
from reflexarc_sim_bridge.worlds.stepping import require_duration

_MOST_STEPS = 64
_NOW = {"latency_steps": "latency_s", "gap_steps": "gap_s"}


@dataclass(frozen=True)
class _FormerSenses:
    """Times of the senses, in steps."""

    latency_steps: int = 0
    gap_steps: int = 1

    def __post_init__(self) -> None:
        require_within("senses.latency_steps", self.latency_steps, 0, _MOST_STEPS)
        require_within("senses.gap_steps", self.gap_steps, 1, _MOST_STEPS)


@dataclass(frozen=True)
class _FormerWorld:
    """What tells how long a step is, and what is told in steps."""

    dt_s: float = 0.1
    senses: _FormerSenses = field(default_factory=_FormerSenses)

    def __post_init__(self) -> None:
        require_duration("dt_s", self.dt_s)


def as_meant(source: Source, resolve: Resolve) -> Source:
    """A world file whose times are in seconds, whatever they were in.

    Args:
        source: the file.
        resolve: what may stand in place of a number.

    Raises:
        ReflexarcError: of the source's class: it tells one time twice, or in steps that cannot be.
    """
    senses, chassis = _table(source, "senses"), _table(source, "chassis")
    former = [name for name in _NOW if name in senses]
    tells_no_time = "slip" in chassis and "slip_over_s" not in chassis
    if not former and not tells_no_time:
        return source
    for name in former:
        if _NOW[name] in senses:
            words = f"expected {_NOW[name]} alone, which is the same in seconds; got both"
            raise source.complaint(("senses", name), words)
    world = fill(_FormerWorld, source, resolve, ignore_unknown=True)
    document = dict(source.document)
    if former:
        document["senses"] = _in_seconds(senses, world)
    if tells_no_time:
        document["chassis"] = {**chassis, "slip_over_s": world.dt_s}
    return _Meant(document, source)


def _in_seconds(senses: Mapping[str, object], world: _FormerWorld) -> dict[str, object]:
    others = {name: value for name, value in senses.items() if name not in _NOW}
    steps = world.senses
    latency_s = steps.latency_steps * world.dt_s
    gap_s = steps.gap_steps * world.dt_s if steps.gap_steps > 1 else 0.0
    return {"latency_s": latency_s, "gap_s": gap_s, **others}


def _table(source: Source, name: str) -> Mapping[str, object]:
    """A table of the file; an empty one where something else stands, which filling refuses."""
    table = source.document.get(name)
    return table if isinstance(table, Mapping) else {}


@dataclass(frozen=True)
class _Meant:
    """A document in place of that of a file, whose complaints go on to name the file's lines."""

    document: Mapping[str, object]
    _file: Source

    def complaint(self, path: KeyPath, words: str) -> ReflexarcError:
        return self._file.complaint(path, words)

    def one_table(self, path: KeyPath) -> str:
        return self._file.one_table(path)

    def many_tables(self, path: KeyPath) -> str:
        return self._file.many_tables(path)
