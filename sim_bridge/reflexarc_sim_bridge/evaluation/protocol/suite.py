"""A suite: which worlds a contender is measured in, and how much of each.

A suite is a TOML file with a version: figures of different versions are never compared. It lists
families of worlds; a family has cells, each a world at one degree of difficulty (tier). In every
cell there are `worlds` test worlds, with `lanes` agents in each that start apart from each other,
and each agent is counted over `free_paths` times the mean free path of an agent that never steers.

    name = "lite"
    version = 1
    worlds = 8
    lanes = 4
    free_paths = 15

    [[families]]
    name = "rectangles"

    [[families.cells]]
    tier = "0.05"
    world = "reference-1"
    clutter = 0.05          # scales the density of what is scattered; without it: as the world says
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Self

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.clutter import at_clutter
from reflexarc_sim_bridge.evaluation.protocol.perturbation import Perturbation, perturbed
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.world import WorldSource

_FOLDER = Path(__file__).parent / "suites"
_SUFFIX = ".toml"


@dataclass(frozen=True)
class SuiteCell:
    """A world at one degree of difficulty."""

    tier: str
    """What is particular about it, in a word: a degree of clutter, a name."""
    world: str
    """Name of a world, or path of its file."""
    clutter: float | None = None
    """Clutter number ρR²v/w, for v = w and a point, to which what is scattered is thinned or
    thickened; None: as the world's file says."""
    free_path_m: float | None = None
    """Mean free path of an agent that never steers; None: 1 / 2ρR of what is scattered."""
    counts: bool = True
    """Whether it is part of the headline."""
    perturbation: Perturbation | None = None
    """What is made worse about it."""

    def __post_init__(self) -> None:
        for name, most in (("clutter", 10.0), ("free_path_m", 1e6)):
            value = getattr(self, name)
            fits = value is None or 0.0 < value <= most
            require(fits, name, f"in (0, {most:g}]", value)

    @cached_property
    def source(self) -> WorldSource:
        """The world, or family of worlds.

        Raises:
            WorldError: there is none of that name; or it cannot have that clutter, or be made so
                much worse.
        """
        source = world_named(self.world)
        if self.clutter is not None:
            source = at_clutter(source, self.clutter)
        return source if self.perturbation is None else perturbed(source, self.perturbation)


@dataclass(frozen=True)
class SuiteFamily:
    """Worlds that ask one kind of question."""

    name: str
    question: str = ""
    """What it asks, in a sentence."""
    is_held_out: bool = True
    """Whether no shipped preset learns in such worlds."""
    cells: tuple[SuiteCell, ...] = ()

    def __post_init__(self) -> None:
        require(bool(self.cells), f"families: {self.name}", "one cell or more", "none")
        tiers = [cell.tier for cell in self.cells]
        require(len(set(tiers)) == len(tiers), f"families: {self.name}", "distinct tiers", tiers)


@dataclass(frozen=True)
class Suite:
    """Families of worlds, and how much of each."""

    name: str
    version: int
    """Figures of different versions are never compared."""
    worlds: int = 8
    """Test worlds of each cell."""
    lanes: int = 4
    """Agents in each world; they start apart and do not see each other."""
    free_paths: float = 15.0
    """How far each is counted, in mean free paths of an agent that never steers."""
    turner_s: float = 60.0
    """For how long a body that turns is watched."""
    families: tuple[SuiteFamily, ...] = field(default_factory=tuple)

    def __post_init__(self) -> None:
        require(1 <= self.worlds <= 4096, "worlds", "1 to 4096", self.worlds)
        require(1 <= self.lanes <= 4096, "lanes", "1 to 4096", self.lanes)
        require(0.0 < self.free_paths <= 1e4, "free_paths", "in (0, 10000]", self.free_paths)
        names = [family.name for family in self.families]
        require(bool(names), "families", "one or more", "none")
        require(len(set(names)) == len(names), "families", "distinct names", names)

    @property
    def cells(self) -> list[tuple[SuiteFamily, SuiteCell]]:
        """All cells, each with its family."""
        return [(family, cell) for family in self.families for cell in family.cells]

    @property
    def title(self) -> str:
        """Name and version."""
        return f"{self.name}-{self.version}"

    def cell(self, name: str) -> SuiteCell:
        """The cell of that name, FAMILY/TIER.

        Raises:
            UsageError: it has none of that name.
        """
        known = {f"{family.name}/{cell.tier}": cell for family, cell in self.cells}
        if name not in known:
            raise UsageError(f"{self.name}: expected one of {', '.join(known)}, got {name!r}")
        return known[name]

    def only(self, families: tuple[str, ...]) -> Self:
        """The suite with some of its families.

        Raises:
            UsageError: it has none of such a name.
        """
        known = [family.name for family in self.families]
        for name in families:
            if name not in known:
                raise UsageError(f"family: expected one of {', '.join(known)}, got {name!r}")
        chosen = tuple(family for family in self.families if family.name in families)
        return replace(self, families=chosen)


def suite_named(name: str) -> Suite:
    """A suite that ships with this package, by its name; or that of a file.

    Raises:
        ReflexarcError: there is none; or the file says what no suite can be.
    """
    if name in _shipped():
        return suite_shipped(name)
    if "/" in name or name.endswith(_SUFFIX):
        return _read(Path(name))
    known = ", ".join(_shipped())
    raise UsageError(f"suite: expected one of {known}, or a file, got {name!r}")


def suite_shipped(name: str) -> Suite:
    """A suite that ships with this package: no file is looked for, whatever the name is.

    Raises:
        UsageError: there is none.
    """
    if name not in _shipped():
        raise UsageError(f"suite: expected one of {', '.join(_shipped())}, got {name!r}")
    return _read(_FOLDER / f"{name}{_SUFFIX}")


def _shipped() -> list[str]:
    return sorted(path.stem for path in _FOLDER.glob(f"*{_SUFFIX}"))


def _read(path: Path) -> Suite:
    return fill(Suite, TomlSource(read_text(path, str(path)), str(path)))
