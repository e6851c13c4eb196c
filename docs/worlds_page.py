"""The page of the worlds: `make worlds`.

Checks every world that is shipped as `reflexarc worlds check NAME` does, draws it as
`reflexarc render NAME -o figures/worlds/NAME.png` does, and writes `worlds.md` from that.
"""

import sys
from pathlib import Path

from reflexarc.terminal.output import progress_bar
from reflexarc_pictures.rendering import render_world
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.evaluation.fairness import (
    CRITICAL_CLUTTER,
    SEEDS,
    WorldReport,
    check_world,
)
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.scenarios import Scenario, scenarios
from reflexarc_sim_bridge.worlds.world import WorldSource

DOCS = Path(__file__).parent
FIGURES = DOCS / "figures" / "worlds"
PAGE = DOCS / "worlds.md"

INTRODUCTION = f"""\
# The worlds

`make worlds` makes this page, its pictures and its figures. A world is a small TOML file:
`reflexarc worlds show NAME` prints one to begin with, and wherever a command takes a name it takes
a file.

Pictures: `reflexarc render NAME -o NAME.png`. An agent that never steers drives for 20 s to the
right, at 1 m/s. Black: its path; yellow: contacts, after which it goes on elsewhere at the same x;
red: what its rays meet at the end. Obstacles that move draw a wake of their last second. Below: its
retina over time.

Figures: `reflexarc worlds check NAME --json`, {SEEDS} seeds.

- blind rate: contacts per 100 m of an agent that never steers, ± its standard error
- 2ρR: the same by the mean free path, where that is known
- cover: the share of the ground that lies under obstacles
- flat within: the largest deviation of the cover anywhere across, as a share of it, ± its error
- clutter: ρR²v/w at equal speeds, of scattered obstacles; above {CRITICAL_CLUTTER} nobody
  passes for ever (Karaman and Frazzoli, arXiv 1202.0253)
- fair: nowhere can an agent hide, and what is met is what there is

## By family
"""

HEAD = """\
| blind rate | 2ρR | cover | flat within | clutter | fair |
|---|---|---|---|---|---|
"""


def main() -> int:
    """Write pictures and page."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    try:
        sections = [_section(name, world) for name, world in WORLDS.items()]
    except ReflexarcError as error:
        print(f"worlds: {error}", file=sys.stderr)
        return 2
    PAGE.write_text("\n".join([f"{INTRODUCTION}\n{_families()}", *sections]), encoding="utf-8")
    return 0


def _families() -> str:
    lines = []
    for family in Scenario:
        names = [name for name, world in WORLDS.items() if family in scenarios(world.drawn(0))]
        lines.append(f"- {family}: {', '.join(f'[{name}](#{name})' for name in names)}\n")
    return "".join(lines)


def _section(name: str, world: WorldSource) -> str:
    with progress_bar(f"checking {name}", 1) as progress:
        report = check_world(world, SEEDS, progress)
    render_world(world, FIGURES / f"{name}.png", progress_bar=progress_bar)
    families = ", ".join(scenarios(world.drawn(0)))
    picture = f"![{name} from above](figures/worlds/{name}.png)"
    return f"## {name}\n\n{world.description} {families}.\n\n{picture}\n\n{HEAD}{_row(report)}\n"


def _row(report: WorldReport) -> str:
    expected = report.expected_blind_contacts_per_100m
    cells = (
        f"{report.blind_contacts_per_100m:.1f} ± {report.blind_error:.1f}",
        "–" if expected is None else f"{expected:.1f}",
        f"{report.cover:.1%}",
        f"{report.flatness:.1%} ± {report.flatness_error:.1%}",
        f"{report.clutter:.3f}",
        "yes" if report.fair else f"no: {'; '.join(report.reasons)}",
    )
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(main())
