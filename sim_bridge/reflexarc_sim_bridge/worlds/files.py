"""Worlds as small TOML files, and those that have a name.

name = "mine"                      # this and one layer are enough; see `World` for all fields
width_m = 20.0
edges = "periodic"

[[layers]]
kind = "scatter"                   # or gates, corridor, automaton
density_per_m2 = { from = 0.2, to = 0.6 }   # a range: every seed draws its own
colour = [0.5, 1.0]                # grey, or three of these: red, green, blue

[[layers.shapes]]
kind = "discs"                     # or rectangles, polygons, curves
radius_m = [0.15, 0.75]

[layers.motion]
kind = "drift"                     # or swing
left_mps = 0.5

[senses]
noise = 0.02                       # at every look
latency_s = 0.1                    # what is seen is so old
gap_s = 0.2                        # longest time from one new retina to the next
mounted_rad = 0.5                  # the eye sits askew, and the policy is not told

[chassis]
radius_m = 0.2
slip = 0.1                         # of every speed, over
slip_over_s = 0.1                  # so long; the same way whatever a step lasts

[limits]                           # of `reflexarc sim`, whatever it is told
linear_mps = 1.5
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.key_path import KeyPath, dotted
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds import ranges as world_ranges
from reflexarc_sim_bridge.worlds.checks import Span
from reflexarc_sim_bridge.worlds.former import as_meant
from reflexarc_sim_bridge.worlds.layers import telling_widths_m
from reflexarc_sim_bridge.worlds.ranges import Choose, resolving
from reflexarc_sim_bridge.worlds.world import World, WorldSource

SUFFIX = ".toml"
MAX_SEED = (1 << 64) - 1

_FOLDER = Path(__file__).parent / "shipped"
_TRIED_SEEDS = 8
_LONGEST_NAME = 60
_LATENCY = "senses", "latency_s"
_SHARED = (
    "scanner",
    "senses.dead_sectors",
    "senses.permuted",
    "senses.mounted_rad",
    dotted(_LATENCY),
    "senses.latency_steps",
    "limits",
)
"""The eye and the limits of the body are the same in all worlds of a family."""


@dataclass(frozen=True, eq=False)
class WorldFamily:
    """Worlds that differ in some numbers: a file with ranges in it."""

    name: str
    description: str
    ranges: Mapping[str, Span]
    """The ends of each range, by the place of the number in the file."""
    _source: TomlSource = field(repr=False)

    @property
    def blind_contacts_per_100m(self) -> None:
        """Unknown: it differs from world to world."""
        return

    @cached_property
    def fullest(self) -> tuple[World, ...]:
        """Worlds at the ends of all ranges that need most memory, one for each telling width."""
        # Where the width is no range, any: the number is not asked for.
        widths_m = telling_widths_m(*self.ranges.get(world_ranges.WIDTH, (0.0, 0.0)))
        return tuple(_world(self._source, world_ranges.farthest_at(w)) for w in widths_m)

    def drawn(self, seed: int) -> World:
        """The world of a seed.

        Raises:
            WorldError: no seed; or a draw that makes no world, which loading has not come across.
        """
        if not 0 <= seed <= MAX_SEED:
            raise WorldError(f"seed: expected 0 to 2^64 − 1, got {seed}")
        return _world(self._source, world_ranges.drawn(int(seed)))


def read_world(path: Path | str) -> WorldSource:
    """Read a world, or a family where numbers are ranges, from a TOML file.

    Raises:
        WorldError: the file cannot be read, or says what no world can be; with line and field.
    """
    return parse_world(read_text(Path(path), str(path), WorldError), str(path))


def parse_world(text: str, name: str = "") -> WorldSource:
    """Read a world, or a family, from TOML text.

    A family has been tried at the lower ends of all ranges, at the upper ends, with its spans at
    their narrowest, where it needs most memory, and on some seeds.

    Args:
        text: the TOML.
        name: how complaints name it.

    Raises:
        WorldError: it says what no world can be.
    """
    source, ranges = TomlSource(text, name, WorldError), dict[str, Span]()

    def note(ends: Span, kind: type, path: KeyPath) -> float:
        if dotted(path).startswith(_SHARED):
            raise ValueError("expected one number for all seeds, got a range")
        ranges[dotted(path)] = ends
        return ends[0]

    world = _world(source, note)
    _check_words(source, world)
    if not ranges:
        return world
    _check_latency(source, world, _world(source, world_ranges.highest))
    for choose in (world_ranges.narrowest, *map(world_ranges.drawn, range(_TRIED_SEEDS))):
        _world(source, choose)
    family = WorldFamily(world.name, world.description, ranges, source)
    _ = family.fullest
    return family


def world_text(name: str) -> str:
    """The TOML of a world: of one with that name, or of that file.

    Raises:
        WorldError: no such world, or no such file.
    """
    path = _path_of(name)
    return read_text(path, str(path), WorldError)


def world_named(name: Path | str) -> WorldSource:
    """The world of that name, or of that file.

    Raises:
        WorldError: no such world; or the file says what no world can be.
    """
    asked = str(name)
    return WORLDS[asked] if asked in WORLDS else read_world(_path_of(asked))


class _ShippedWorlds(Mapping[str, WorldSource]):
    """The worlds of this package by their names, each read when it is first asked for."""

    def __getitem__(self, name: str) -> WorldSource:
        if name not in _names():
            raise KeyError(name)
        return _shipped(name)

    def __iter__(self) -> Iterator[str]:
        return iter(_names())

    def __len__(self) -> int:
        return len(_names())

    def __contains__(self, name: object) -> bool:
        return name in _names()


WORLDS: Mapping[str, WorldSource] = _ShippedWorlds()


@cache
def _names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in _FOLDER.glob(f"*{SUFFIX}")))


@cache
def _shipped(name: str) -> WorldSource:
    return read_world(_FOLDER / f"{name}{SUFFIX}")


def _path_of(name: str) -> Path:
    if name in _names():
        return _FOLDER / f"{name}{SUFFIX}"
    if "/" in name or name.endswith(SUFFIX):
        return Path(name)
    known = ", ".join(_names())
    raise WorldError(
        f"world: no world is named {name!r}; known: {known}; or give a file, *{SUFFIX}"
    )


def _world(source: TomlSource, choose: Choose) -> World:
    resolve = resolving(choose)
    return fill(World, as_meant(source, resolve), resolve)


def _check_latency(source: TomlSource, quickest: World, slowest: World) -> None:
    """Refuse steps of different durations in which a latency is not as many of them everywhere."""
    most, least = quickest.latency_steps, slowest.latency_steps
    if most != least:
        words = f"as many steps for every seed, got {least} to {most}; give dt_s one number"
        raise source.complaint(_LATENCY, f"expected {words}")


def _check_words(source: TomlSource, world: World) -> None:
    """Refuse a name or a description that would break a line of a terminal, a table or a log."""
    if not (world.name.isprintable() and 1 <= len(world.name) <= _LONGEST_NAME):
        wanted = f"1 to {_LONGEST_NAME} printable characters"
        raise source.complaint(("name",), f"expected {wanted}, got {world.name[:80]!r}")
    if not world.description.isprintable():
        raise source.complaint(("description",), "expected one line, got a line break in it")
