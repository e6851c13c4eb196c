"""One run, as a process of its own does it: warm up, learn, measure on test worlds."""

import json
from dataclasses import asdict
from typing import Any

from learning_race.contenders import Contender
from learning_race.judge import LEVELS, Clock, Judge
from learning_race.learn import in_time, learn, warm_up
from learning_race.schedule import Scale
from learning_race.threads import set_threads
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

COLD_LIMIT_S = 600.0


def warm_record(contender: Contender, seed: int, scale: Scale) -> str:
    """Do a warm run, with everything loaded and compiled; returns its record, a line of JSON."""
    contender = scale.limited(contender)
    set_threads(contender)
    rate = warm_up(contender)
    judge = Judge(Clock(), contender.budget_s, contender.stops_at)
    learn(in_time(contender, rate), seed, judge)
    return json.dumps(_record(contender, seed, judge) | _tested(judge, scale))


def cold_record(contender: Contender, seed: int, scale: Scale, started_s: float) -> str:
    """Do a cold run up to the first level, in a process that began at `started_s`."""
    set_threads(contender)
    judge = Judge(Clock(started_s), COLD_LIMIT_S, LEVELS[0], starts_cold=True)
    judge.due_s = judge.clock.seconds
    learn(contender.learner, seed, judge)
    return json.dumps(_record(contender, seed, judge))


def _record(contender: Contender, seed: int, judge: Judge) -> dict[str, Any]:
    return {
        "contender": contender.name,
        "settings": contender.settings_hash,
        "seed": seed,
        "budget_s": contender.budget_s,
        "seconds": judge.ended_s,
        "looks": [list(asdict(look).values()) for look in judge.looks],
    }


def _tested(judge: Judge, scale: Scale) -> dict[str, Any]:
    """The part of a record with contacts per 100 m on test worlds, and its interval."""
    assert judge.last is not None, "a run ends with a look"
    score = measure(
        judge.last, reference_contract(), agents=scale.test_agents, steps=scale.test_steps
    )
    return {"test": [score.contacts_per_100m, score.low, score.high]}
