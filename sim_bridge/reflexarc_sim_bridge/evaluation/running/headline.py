"""The headline score of one policy, in this process alone: for who measures many of them.

The numbers are those of `run_suite`. What is possible in a cell is asked once a process and motion.
"""

from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite
from reflexarc_sim_bridge.evaluation.running.doing import PlainSums, do_unit
from reflexarc_sim_bridge.evaluation.running.plan import Job, plan_suite, starters_of
from reflexarc_sim_bridge.evaluation.running.run_suite import drive_here, results_of
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards

_limits: dict[str, PlainSums] = {}
"""Sums of limits by the key of their job, which holds all that they depend on."""


def headline(contender: Contender, suite: Suite, setting: Setting) -> float:
    """Mean over families of the score between blind (0) and oracle (1).

    Args:
        contender: an object; each cell drives a copy of it.
        suite: where.
        setting: at which rate, with which body.

    Raises:
        ReflexarcError: it cannot drive there.
    """
    starters = starters_of([contender])
    jobs, limits = plan_suite(suite, starters, (setting,))
    there = {job.key: drive_here(job, suite) for job in jobs}
    there |= {job.key: _limit(job) for job in limits}
    (card,) = score_cards(results_of(suite, starters, jobs, limits, there))
    return card.headline.value


def _limit(job: Job) -> PlainSums:
    if job.key not in _limits:
        assert job.unit is not None
        _limits[job.key] = do_unit(job.unit)
    return _limits[job.key]
