"""`reflexarc baselines`: lists the earlier systems, searches, evolves or exports one."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from reflexarc.terminal.output import aside, console, facts, plain, print_json, progress_bar
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from rich.table import Table

    from reflexarc_baselines.search import SearchReport, TriedSetting

_WRITES = ("evolve", "export")
_SHOWN = 10
"""So many of the best trials are shown."""


@dataclass(frozen=True)
class BaselinesCommand:
    """List the earlier systems and plain rules that learned policies are compared with, or use one.

    `search` gives one the budget that each of them got: random settings of its free parameters,
    measured on validation worlds of its home world. `evolve` breeds one anew whose source evolved
    it, and writes the genome (TOML). `export` writes one as a policy file, which `run` drives by
    and `replay` replays; the file is held to what the baseline itself decides.

    Examples:
      reflexarc baselines
      reflexarc baselines search potential-field
      reflexarc baselines evolve evolved-viewing --seed 1 -o mine.toml
      reflexarc baselines export subsumption --rate 50 -o subsumption.onnx
    """

    action: tyro.conf.Positional[Literal["list", "search", "evolve", "export"]] = "list"
    """What to do."""
    name: tyro.conf.Positional[str] = ""
    """Which baseline, for all but list."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """The file that evolve (TOML) or export (ONNX) writes."""
    seed: int = 0
    """Of all chance in search and evolve."""
    trials: int = 64
    """Settings that search draws; the figures that are published have 64."""
    rate: float | None = None
    """Decisions a second of the exported file; if not given, the baseline's own."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """List, search, evolve or export; return the exit status."""
        if (self.action == "list") != (self.name == ""):
            wanted = "no name" if self.action == "list" else "the name of a baseline"
            raise UsageError(f"{self.action}: expected {wanted}, got {self.name or 'none'}")
        if (self.out is not None) != (self.action in _WRITES):
            wanted = "-o FILE" if self.action in _WRITES else "no file to write"
            raise UsageError(f"{self.action}: expected {wanted}, got {self.out or 'none'}")
        if self.rate is not None and self.action != "export":
            raise UsageError(f"--rate: only export has one, not {self.action}")
        actions = {"list": self._list, "search": self._search}
        return (actions | {"evolve": self._evolve, "export": self._export})[self.action]()

    def _list(self) -> int:
        from reflexarc_baselines.registry import HOMES

        rows = [_row(name) for name in HOMES]
        if self.json:
            print_json({"baselines": rows})
        else:
            console.print(_table(rows))
        return 0

    def _search(self) -> int:
        from reflexarc_baselines.search import SearchBudget, search

        budget = SearchBudget(trials=self.trials)
        with progress_bar(self.name, 1 + self.trials) as progress:
            report = search(self.name, budget=budget, seed=self.seed, progress=progress)
        if self.json:
            print_json(report)
        else:
            console.print(_trials(report))
        return 0

    def _evolve(self) -> int:
        assert self.out is not None
        from reflexarc_baselines.evolving.evolution import Generation, evolve
        from reflexarc_baselines.genome_files import genome_text
        from reflexarc_runtime.files import write_atomically

        def show(now: Generation) -> None:
            aside.print(
                f"generation {now.number}: best {now.best:.2f}; on validation worlds "
                f"{now.validation:.2f}, record {now.record:.2f}, {now.since} generations ago"
            )

        evolved = evolve(self.name, self.seed, show)
        write_atomically(self.out, genome_text(evolved.genome, evolved.provenance).encode())
        said = {"genome": self.out, "validation": evolved.provenance.validation}
        if self.json:
            print_json(said)
        else:
            console.print(facts(said))
        return 0

    def _export(self) -> int:
        assert self.out is not None
        from reflexarc_baselines.exporting.exporting import export_baseline
        from reflexarc_baselines.registry import PYTHON_ONLY, baseline_named
        from reflexarc_runtime.policy.policy import load_policy

        if reason := PYTHON_ONLY.get(self.name):
            raise UsageError(f"export: {self.name} cannot be a policy file: {reason}")
        contract = export_baseline(
            baseline_named(self.name), self.name, self.out, rate_hz=self.rate
        )
        policy = load_policy(self.out, bounds=None)
        said = {
            "policy": self.out,
            "policy_hash": policy.policy_hash,
            "rate_hz": contract.rate_hz,
            "q_tolerance": contract.q_tolerance,
        }
        if self.json:
            print_json(said)
        else:
            console.print(facts(said))
        return 0


def _row(name: str) -> dict[str, Any]:
    """What there is to say about a baseline."""
    from reflexarc_baselines.registry import PYTHON_ONLY, baseline_named

    baseline = baseline_named(name)
    origin, reason = baseline.ORIGIN, PYTHON_ONLY.get(name)
    return {
        "name": name,
        "source": origin.source,
        "fidelity": origin.fidelity,
        "sees": origin.sees,
        "home_world": origin.home_world,
        "remarks": origin.remarks,
        "parameters": {free: getattr(baseline, free) for free in baseline.SEARCHED},
        "memory": baseline.contract.state.size,
        "exports": reason is None,
        "python_only_because": reason or "",
    }


def _table(rows: list[dict[str, Any]]) -> "Table":
    """A table with one row for each baseline."""
    from rich.table import Table

    table = Table(caption="Parameters: those that were searched.", caption_justify="left")
    table.add_column("baseline", no_wrap=True)
    for title in ("source", "fidelity", "sees", "home world", "parameters", "exports"):
        table.add_column(title)
    for row in rows:
        parameters = _words(row["parameters"])
        exports = "yes" if row["exports"] else f"no: {row['python_only_because']}"
        told = (row["source"], row["fidelity"], row["sees"], row["home_world"])
        table.add_row(row["name"], *map(plain, told), parameters, exports)
    return table


def _trials(report: "SearchReport") -> "Table":
    """The best trials of a search, and what is shipped."""
    from rich.table import Table

    budget = report.budget
    title = (
        f"{report.name}: contacts per 100 m in {report.world}, {len(report.trials)} trials of "
        f"{budget.agents} agents × {budget.steps} steps, seed {report.seed}"
    )
    table = Table(title=title, title_justify="left")
    table.add_column("", no_wrap=True)
    table.add_column("contacts / 100 m", justify="right")
    table.add_column("setting")
    _add(table, "shipped", report.shipped)
    for place, trial in enumerate(report.trials[:_SHOWN], start=1):
        _add(table, str(place), trial)
    return table


def _add(table: "Table", what: str, trial: "TriedSetting") -> None:
    table.add_row(what, f"{trial.contacts_per_100m:.2f}", _words(trial.setting))


def _words(setting: Any) -> str:
    return ", ".join(f"{name} {value:.3g}" for name, value in setting.items()) or "none"
