"""A race in learning to avoid obstacles: our learners against those of Stable-Baselines3.

    python benchmarks/learning.py --out runs/learning          everything: runs, table, figure
    ... --contenders reflex-short,ppo-tuned --seeds 3          some contenders, fewer seeds
    ... --quick                                                a test run of about a minute
    ... --plan                                                 list the runs and their durations
    ... --report                                               table and figure of existing runs

All contenders learn in the same compiled world, the reference field with its eye. Each run is a
process of its own, pinned to the same cores; for each seed all contenders run in turn. The clock
starts with the first weights, when all code is loaded and compiled (warm), or with the process and
an empty compilation cache (cold). It is stopped while the frozen greedy policy is measured on
validation worlds (a look). A contender reaches a level at the first of two looks in a row that pass
it. The time to the first level is measured once more without looks, which slow short runs down. The
final policy of a run is measured on test worlds, as `reflexarc evaluate` does. Existing runs are
not repeated. Needs `pip install stable-baselines3 sb3-contrib`. The contenders are defined in
`learning_race/contenders.py`; `learning_race/tuning.md` lists how they were tuned.
"""

import argparse
import os
import sys
from pathlib import Path
from typing import NoReturn

os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from learning_race.contenders import CONTENDERS, Contender, named  # threads first
from learning_race.schedule import Entry, Scale, cold_entries, run_all, warm_entries

LEAST_COLD_SEEDS = 3


def main() -> None:
    """Do the missing runs, then print table and comparisons; or do one run, as a child process."""
    options = _options()
    if options.child:
        _be_a_child(options)
        return
    if options.seeds < 1 or options.budget_s <= 0.0 or options.cold < 0:
        _refuse("expected --seeds 1 or more, --budget-s above 0, --cold 0 or more")
    entries, out = _entries(options), Path(options.out) / ("quick" * options.quick)
    if options.plan:
        _say_plan(entries)
        return
    if options.report and not out.is_dir():
        _refuse(f"--out: no runs are in {out}; leave out --report to make some")
    if not options.report:
        run_all(entries, out, _scale(options))
        from learning_race.undisturbed import time_all

        time_all(out, {entry.contender.name: entry.contender for entry in entries})
    from learning_race.report import write_report

    print(write_report(out))


def _refuse(reason: str) -> NoReturn:
    print(f"learning: {reason}", file=sys.stderr)
    raise SystemExit(2)


def _be_a_child(options: argparse.Namespace) -> None:
    """Do one run, and write its record to standard output as one line."""
    from learning_race.one_run import cold_record, warm_record

    contender, scale = named(options.child), _scale(options)
    if options.undisturbed:
        from learning_race.undisturbed import undisturbed_s

        print(undisturbed_s(contender, options.seed, options.undisturbed))
        return
    if options.started_s is not None:
        line = cold_record(contender, options.seed, scale, options.started_s)
    else:
        line = warm_record(contender, options.seed, scale)
    print(line)


def _entries(options: argparse.Namespace) -> list[Entry]:
    contenders = _chosen(options.contenders)
    seeds = 1 if options.quick else options.seeds
    cold = 0 if options.quick else options.cold
    return [*warm_entries(contenders, seeds), *cold_entries(contenders, cold)]


def _chosen(names: str | None) -> list[Contender]:
    return [named(name) for name in names.split(",")] if names else list(CONTENDERS)


def _scale(options: argparse.Namespace) -> Scale:
    if options.quick:
        return Scale(budget_s=2.0, test_agents=256, test_steps=300)
    return Scale(options.budget_s, options.test_agents, options.test_steps)


def _say_plan(entries: list[Entry]) -> None:
    for entry in entries:
        print(f"{entry.name:<28}{entry.most_s:>8.0f} s")
    print(f"{len(entries)} runs, at most {sum(e.most_s for e in entries) / 60:.0f} minutes")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--out", default="runs/learning", help="folder of the runs")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--budget-s", type=float, default=60.0, help="most seconds of a run")
    parser.add_argument("--contenders", help="names, separated by commas")
    parser.add_argument("--cold", type=int, default=LEAST_COLD_SEEDS, help="cold runs of each")
    parser.add_argument("--test-agents", type=int, default=4096)
    parser.add_argument("--test-steps", type=int, default=2000)
    for flag in ("--quick", "--plan", "--report"):
        parser.add_argument(flag, action="store_true")
    parser.add_argument("--child", metavar="NAME", help=argparse.SUPPRESS)
    parser.add_argument("--seed", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--undisturbed", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--started-s", type=float, help=argparse.SUPPRESS)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
