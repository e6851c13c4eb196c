"""`reflexarc study`: learns with a grid of configurations × seeds, and compares the results."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc.terminal.output import aside, console, plain, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.words.suggestion import pasteable

if TYPE_CHECKING:
    from rich.table import Table

    from reflexarc_trainer.study.definition import Study
    from reflexarc_trainer.study.study import StudyResult
    from reflexarc_trainer.study.summary import CellSummary

NOT_AS_WANTED = 1


@dataclass(frozen=True)
class StudyCommand:
    """Learn with every configuration of a grid and every seed, and compare what was learned.

    A study is a small TOML file; --list says which are shipped, --show prints one to begin with.
    Runs are shared among processes; one that dies is replaced. Results are kept one by one: after
    Ctrl-C, or worse, the same command goes on. Writes study.md with a table and study.png
    (interquartile means over seeds, 95 % bootstrap intervals) into runs/study-NAME. Exit status:
    0 done, 1 a run failed or a target is missed, 2 no study.

    Examples:
      reflexarc study --list
      reflexarc study hidden
      reflexarc study --show hidden > mine.toml
      reflexarc study mine.toml --dry-run
      reflexarc study mine.toml --jobs 8 -o runs/mine
    """

    study: tyro.conf.Positional[str] = ""
    """Which: the name of one that is shipped, or a file."""
    jobs: int = 0
    """Processes; by default as many as there are processors."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Folder to write to; runs/study-NAME by default."""
    any_code: bool = False
    """Use results in the folder that other versions of the code gave, too."""
    dry_run: bool = False
    """Say what would be done, and how long it may take."""
    list: bool = False
    """List the studies that are shipped."""
    show: bool = False
    """Print the study's file."""
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """List, show, plan or run a study; return the exit status."""
        if self.list != (self.study == ""):
            wanted = "no study with --list" if self.list else "the name or the file of a study"
            raise UsageError(f"study: expected {wanted}, got {self.study or 'none'}; see --list")
        if self.list:
            return self._list()
        from reflexarc_runtime.crew.crew import MOST_JOBS
        from reflexarc_trainer.study.shipped import study_named

        if not 0 <= self.jobs <= MOST_JOBS:
            raise UsageError(f"--jobs: expected 1 to {MOST_JOBS}, got {self.jobs}")
        study = study_named(self.study)
        if self.show:
            print(study.text, end="")
            return 0
        out = self.out or Path("runs") / f"study-{study.name}"
        return self._plan(study, out) if self.dry_run else self._run(study, out)

    @property
    def _processes(self) -> int:
        return self.jobs or len(os.sched_getaffinity(0))

    def _list(self) -> int:
        from reflexarc_trainer.study.shipped import study_named, study_names

        rows = [_facts(study_named(name)) for name in study_names()]
        if self.json:
            print_json({"studies": rows})
        else:
            console.print(_list_table(rows))
        return 0

    def _plan(self, study: "Study", out: Path) -> int:
        from reflexarc_trainer.study.study import plan

        todo = plan(study, out, self.any_code)
        seconds = todo.estimate_s(self._processes)
        if self.json:
            cells = [{"cell": c.name, "config_hash": c.config.hash} for c in study.cells]
            counts = {"units": len(todo.units), "pending": len(todo.pending)}
            print_json({**_facts(study), "cells": cells, **counts, "estimate_s": seconds})
            return 0
        for cell in study.cells:
            console.print(f"{plain(cell.name)}  ({cell.config.steps:,} steps)")
        seeds = f"{len(study.cells)} cells × {len(study.seeds)} seeds"
        console.print(f"{seeds} = {len(todo.units)} runs, {len(todo.pending)} of them to do: about")
        console.print(f"{seconds / 60:.1f} minutes with --jobs {self._processes}, in {out}")
        return 0

    def _run(self, study: "Study", out: Path) -> int:
        from reflexarc.terminal.progress import show_study_progress
        from reflexarc_trainer.study.study import run_study

        with StopFlag() as stop, show_study_progress() as progress:
            result = run_study(
                study,
                out,
                self._processes,
                any_code=self.any_code,
                progress=progress,
                should_stop=stop,
            )
        if self.json:
            print_json(_summary(study, result))
        else:
            from reflexarc_trainer.study.answer import answer

            console.print(_table(study, result))
            console.print(answer(study, result.summaries))
            console.print(f"page: {plain(str(result.page))}")
        return self._answer(result)

    def _answer(self, result: "StudyResult") -> int:
        """Print what failed or is missing; return the exit status."""
        if result.unused:
            said = "results of other code are not used; --any-code uses them"
            aside.print(f"{result.unused} {said}")
        for words in result.failures:
            aside.print(f"failed: {plain(words)}")
        for words in result.missed:
            aside.print(f"missed: {plain(words)}")
        if result.interrupted:
            where = ("-o", result.out) if self.out else ()
            again = pasteable("reflexarc", "study", self.study, *where)
            aside.print(f"interrupted; go on with: {again}", soft_wrap=True)
        return NOT_AS_WANTED if result.failures or result.missed else 0


def _facts(study: "Study") -> dict[str, object]:
    return {
        "name": study.name,
        "title": study.title,
        "question": study.question,
        "cells": len(study.cells),
        "seeds": len(study.seeds),
    }


def _list_table(rows: "list[dict[str, object]]") -> "Table":
    from rich.table import Table

    table = Table()
    table.add_column("study", no_wrap=True)
    table.add_column("runs", justify="right")
    table.add_column("question")
    for row in rows:
        runs = f"{row['cells']} × {row['seeds']}"
        table.add_row(str(row["name"]), runs, plain(str(row["question"])))
    return table


def _table(study: "Study", result: "StudyResult") -> "Table":
    from rich.table import Table

    from reflexarc_trainer.study.measure_words import FIGURE_NAMES

    table = Table(title=f"{study.title}: {FIGURE_NAMES[study.measure]}", title_justify="left")
    table.add_column("cell")
    for name in ("seeds", "mean", "95 % interval", "of blind"):
        table.add_column(name, justify="right")
    for summary in result.summaries:
        table.add_row(plain(summary.cell.name), *_row(summary))
    return table


def _row(summary: "CellSummary") -> tuple[str, ...]:
    seeds = str(len(summary.figures)) + f" + {summary.diverged} diverged" * bool(summary.diverged)
    if summary.estimate is None:
        return (seeds, "–", "–", "–")
    mean, low, high = summary.estimate
    share = "–" if summary.share_of_blind is None else f"{summary.share_of_blind:.3f}"
    return (seeds, f"{mean:.3g}", f"{low:.3g} – {high:.3g}", share)


def _summary(study: "Study", result: "StudyResult") -> dict[str, object]:
    cells = [
        {
            "cell": summary.cell.name,
            "figures": summary.figures,
            "estimate": summary.estimate and summary.estimate._asdict(),
            "share_of_blind": summary.share_of_blind,
            "never_steering": summary.blind,
            "diverged": summary.diverged,
            "missing": summary.missing,
        }
        for summary in result.summaries
    ]
    from reflexarc_trainer.study.answer import answer

    return {
        "study": study.name,
        "answer": answer(study, result.summaries),
        "measure": study.measure,
        "cells": cells,
        "done": result.done,
        "units": result.units,
        "failed": result.failures,
        "interrupted": result.interrupted,
        "missed": result.missed,
        "page": result.page,
    }
