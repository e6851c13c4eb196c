"""The time to the first level without looks.

A look stops the clock, but slows the learner down afterwards: it fills the processor's caches, and
threads go to sleep. For a run of a second that is nothing, for one of a hundredth it is much. So a
contender that has reached the first level learns once more with the same seed, in a new process,
for as many world steps as it took, without looks.
"""

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from learning_race.contenders import AnyLearner, Contender, Ours
from learning_race.judge import LEVELS, Clock, Judge, reached
from learning_race.learn import in_time, new_model, steps_a_transition, warm_up
from learning_race.record import read_record
from learning_race.results import read_runs
from learning_race.schedule import PROGRAM, on_cores
from learning_race.threads import set_threads
from reflexarc_runtime.files import write_atomically
from reflexarc_trainer.sarsa.forms import new_learner


def time_all(out: Path, contenders: dict[str, Contender]) -> None:
    """Measure the time for every run that reached the first level, if its record does not have it.

    Raises:
        SystemExit: a run failed.
    """
    for name, runs in read_runs(out).items():
        for run in runs:
            look = reached(run.looks, LEVELS[0])
            if name in contenders and look is not None and run.undisturbed_s is None:
                seconds = _in_a_process(contenders[name], run.seed, look.world_steps)
                _add(out / f"{name}-{run.seed}.json", seconds)


def undisturbed_s(contender: Contender, seed: int, world_steps: int) -> float:
    """Time to learn for a number of world steps, from the first weights on, in seconds."""
    set_threads(contender)
    learner = in_time(contender, warm_up(contender))
    began_s = time.monotonic()
    _learn(learner, seed, world_steps, contender.budget_s)
    return time.monotonic() - began_s


def _learn(learner: AnyLearner, seed: int, world_steps: int, budget_s: float) -> None:
    if isinstance(learner, Ours):
        steps = world_steps // steps_a_transition(learner)
        new_learner(replace(learner.config, seed=seed)).run(steps)
        return
    judge = Judge(Clock(), budget_s)  # its clock is what the schedules follow
    new_model(learner, seed, judge).learn(world_steps // learner.held_steps)


def _in_a_process(contender: Contender, seed: int, world_steps: int) -> float:
    print(f"without looks: {contender.name}-{seed}", file=sys.stderr, flush=True)
    command = [sys.executable, str(PROGRAM), "--child", contender.name, "--seed", str(seed)]
    done: subprocess.CompletedProcess[str] = on_cores(
        contender.cores, [*command, "--undisturbed", str(world_steps)], None
    )
    if done.returncode:
        raise SystemExit(f"learning: {contender.name}-{seed} failed: {done.returncode}")
    return float(done.stdout)


def _add(path: Path, seconds: float) -> None:
    record = read_record(path) | {"undisturbed_s": seconds}
    write_atomically(path, json.dumps(record).encode())
