"""One run of a study: learn by a unit's configuration, then measure the greedy policy.

The figures of a result are a pure function of the unit: they are the same in any process, and on
any machine with the same arithmetic. Its times are not.
"""

import hashlib
import time
from functools import lru_cache

import numpy as np

from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.metrics.edge_index import (
    edge_index,
    obstacle_radius_m,
    require_edge_index,
)
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.evaluation.reference_field import measure as measure_contacts
from reflexarc_sim_bridge.evaluation.running.headline import headline
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import WorldSource
from reflexarc_trainer.config.embodied import embodied
from reflexarc_trainer.config.training_world import TrainingWorld
from reflexarc_trainer.policy.weights import network_of
from reflexarc_trainer.run.train import CHUNK_STEPS
from reflexarc_trainer.run.validation import GreedyPolicy
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.sarsa.learner_interface import Learner
from reflexarc_trainer.study.unit import Evaluation, Measure, Result, Unit, code_key

_SUITE = "lite"


def measure(unit: Unit) -> Result:
    """Learn, then measure. If the weights diverge, the result says so.

    Raises:
        WorldError: the simulation does not support the world or the eye.
        UsageError: the edge index is to be measured in a world that has none.
    """
    began_s = time.perf_counter()
    learner = new_learner(unit.config)
    stayed_finite = _learn(learner)
    learned_s = time.perf_counter()
    figures = _figures(unit, learner) if stayed_finite else {}
    return Result(
        unit=unit.hash,
        code=code_key(),
        diverged=not stayed_finite,
        steps=learner.step,
        learning_s=round(learned_s - began_s, 3),
        evaluation_s=round(time.perf_counter() - learned_s, 3),
        weights_hash=hashlib.sha256(learner.weights.tobytes()).hexdigest(),
        **figures,
    )


def measure_edge_index(
    policy: Policy, contract: PolicyContract, world: WorldSource, scale: Evaluation
) -> float:
    """The edge index of a policy, from the agents' lateral positions after every step.

    Args:
        policy: chooses the actions.
        contract: what it sees and does.
        world: each agent is in the world of another test seed.
        scale: numbers of agents and steps.

    Raises:
        UsageError: the world has no edges.
    """
    sides = require_edge_index(world)
    simulation = Simulation(sides, contract, test_seeds(scale.agents))
    pilot = Pilot(policy, contract, scale.agents, simulation.dt_s)
    lateral_m = np.empty((scale.steps, scale.agents))
    for step in range(-scale.discard, scale.steps):
        simulation.sense()
        simulation.step(pilot.act(simulation.stacks))
        if step >= 0:
            lateral_m[step] = simulation.y_m
    return edge_index(lateral_m, sides.width_m, obstacle_radius_m(sides))


def _learn(learner: Learner) -> bool:
    """Learn to the end of the run; returns False if the weights diverge."""
    while learner.step < learner.config.steps:
        try:
            learner.run(min(CHUNK_STEPS, learner.config.steps - learner.step))
        except UsageError:  # `Learner.run` raises it for weights that are no longer finite
            return False
    return True


def _figures(unit: Unit, learner: Learner) -> dict[str, float | None]:
    """The figures of the greedy policy, by the names of the fields of `Result`."""
    policy, contract = GreedyPolicy(network_of(learner), unit.config), unit.config.contract()
    assert unit.world is not None  # filled in
    config, scale = unit.config, unit.evaluation
    contacts = _contacts(policy, contract, config.source_of(unit.world), scale)
    blind = _blind_contacts(contract.actions, unit.world, config.body, scale)
    figures: dict[str, float | None] = {
        "contacts_per_100m": contacts,
        "share_of_blind": contacts / blind if blind else None,
        "blind_per_100m": blind,
    }
    if unit.measure is Measure.EDGE_INDEX:
        world = config.source_of(unit.world)
        figures["edge_index"] = measure_edge_index(policy, contract, world, unit.evaluation)
    if unit.measure is Measure.SUITE:
        contender = Contender("greedy", policy, contract)
        figures["suite_score"] = headline(contender, suite_named(_SUITE), Setting.FIELD)
    return figures


@lru_cache(maxsize=64)
def _blind_contacts(
    actions: tuple[Action, ...], world: TrainingWorld, body: BodySpec | None, scale: Evaluation
) -> float:
    """Contacts per 100 m of an agent that never steers, in the same worlds; its eye has no effect.

    Measured once per process.
    """
    contract = PolicyContract(actions=actions)
    source = embodied(world.source(), body, contract.max_input_age_s)
    return _contacts(BlindPolicy(len(actions)), contract, source, scale)


def _contacts(
    policy: GreedyPolicy | BlindPolicy,
    contract: PolicyContract,
    world: WorldSource,
    scale: Evaluation,
) -> float:
    score = measure_contacts(
        policy,
        contract,
        agents=scale.agents,
        steps=scale.steps,
        discard=scale.discard,
        world=world,
    )
    return score.contacts_per_100m
