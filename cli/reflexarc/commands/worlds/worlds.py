"""`reflexarc worlds`: lists the worlds, shows one, or checks whether one is fair."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from reflexarc.terminal.output import console, facts, plain, print_json, progress_bar
from reflexarc_pictures.rendering import check_place
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from rich.table import Table

    from reflexarc_sim_bridge.evaluation.fairness import WorldReport

UNFAIR = 1


@dataclass(frozen=True)
class WorldsCommand:
    """List the worlds that have a name, show the file of one, or check whether one is fair.

    A world is a small TOML file; wherever another command takes the name of a world it takes a
    file, too. `show` prints one to begin with. `check` measures on many seeds how evenly obstacles
    cover a world from side to side, and how often an agent that never steers meets them. Exit
    status: 0 fair, 1 unfair, 2 no world.

    Examples:
      reflexarc worlds
      reflexarc worlds show crossing > mine.toml
      reflexarc worlds check mine.toml -o mine.png
      reflexarc worlds check legacy --json
    """

    action: tyro.conf.Positional[Literal["list", "show", "check"]] = "list"
    """What to do."""
    world: tyro.conf.Positional[str] = ""
    """Which world, for show and check: a name or a file."""
    seeds: int = 64
    """Check so many of its endless variants."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Draw what check measured (PNG)."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """List, show or check worlds; return the exit status."""
        if self.action != "check" and self.out is not None:
            raise UsageError(f"--out: only check draws, not {self.action}")
        if self.out is not None and self.out.suffix.lower() != ".png":
            raise UsageError(f"--out: expected a name that ends in .png, got {self.out}")
        if self.out is not None:
            check_place(self.out)
        if (self.action == "list") != (self.world == ""):
            wanted = "no world" if self.action == "list" else "the name or the file of a world"
            raise UsageError(f"{self.action}: expected {wanted}, got {self.world or 'none'}")
        return {"list": self._list, "show": self._show, "check": self._check}[self.action]()

    def _list(self) -> int:
        from reflexarc_sim_bridge.worlds.files import WORLDS
        from reflexarc_sim_bridge.worlds.scenarios import scenarios

        rows = [
            {"name": name, "families": scenarios(world.drawn(0)), "description": world.description}
            for name, world in WORLDS.items()
        ]
        if self.json:
            print_json({"worlds": rows})
        else:
            console.print(_table(rows))
        return 0

    def _show(self) -> int:
        from reflexarc_sim_bridge.worlds.files import world_named, world_text

        source, text = world_named(self.world), world_text(self.world)
        if self.json:
            print_json({"name": source.name, "description": source.description, "toml": text})
        else:
            print(text, end="")
        return 0

    def _check(self) -> int:
        from reflexarc_sim_bridge.worlds.files import world_named

        source = world_named(self.world)
        from reflexarc_sim_bridge.evaluation.fairness import check_world  # loads the simulator

        with progress_bar(source.name, 1) as progress:
            report = check_world(source, self.seeds, progress)
        if self.out is not None:
            from reflexarc_pictures.fairness_picture import draw_world

            draw_world(source, report, self.out)
        if self.json:
            print_json(report)
        else:
            console.print(facts(_rows(report)))
        return 0 if report.fair else UNFAIR


def _table(rows: list[dict[str, Any]]) -> "Table":
    """A table with one row for each world; the caption says what the numbers of families mean."""
    from rich.table import Table

    from reflexarc_sim_bridge.worlds.scenarios import Scenario

    caption = f"Families: {', '.join(Scenario)}."
    table = Table(caption=caption, caption_justify="left")
    table.add_column("world", no_wrap=True)
    table.add_column("families")
    table.add_column("what it is")
    for row in rows:
        numbers = " ".join(family.partition(" ")[0] for family in row["families"])
        table.add_row(row["name"], numbers, row["description"])
    return table


def _rows(report: "WorldReport") -> dict[str, object]:
    expected = report.expected_blind_contacts_per_100m
    blind = f"{report.blind_contacts_per_100m:.2f} ± {report.blind_error:.2f} contacts per 100 m"
    path_m = report.mean_free_path_m
    return {
        "world": f"{plain(report.name)}, {report.seeds} seeds",
        "verdict": "fair" if report.fair else f"unfair: {'; '.join(report.reasons)}",
        "cover": f"{report.cover:.1%}",
        "flat within": f"{report.flatness:.1%} ± {report.flatness_error:.1%} of it",
        "never steering": blind + (f", 2ρR says {expected:.2f}" if expected is not None else ""),
        "mean free path": f"{path_m:.2f} m" if path_m is not None else "endless",
        "clutter": f"{report.clutter:.3f}",
        **({"note": "; ".join(report.notes)} if report.notes else {}),
    }
