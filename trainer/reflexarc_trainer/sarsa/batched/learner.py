"""The batched learner: many agents, each in an endless world of its own, that share their weights.

It calls the compiled `update.learn` on as many threads as there are processors.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.threads import thread_count, together
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step_pointer import NO_STEP, NOTHING_HELD
from reflexarc_sim_bridge.worlds.seeds import TRAINING_SEEDS, all_of
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import stage_at, stage_ends
from reflexarc_trainer.sarsa.batched.barrier import new_barrier
from reflexarc_trainer.sarsa.batched.state import (
    NOT_CHOSEN,
    WorldAccess,
    new_learning,
    update_rules_for,
)
from reflexarc_trainer.sarsa.batched.update import learn
from reflexarc_trainer.sarsa.learner_interface import (
    STAGE,
    WORLD,
    Arrays,
    Report,
    check_finite,
    counts,
    report_between,
    restore_arrays,
    saved_stage,
    world_arrays,
)
from reflexarc_trainer.sarsa.schedules import linear


class BatchedLearner:
    """A learner at some step of its run; see `Learner`.

    Args:
        config: the run; its seed gives the initial weights, the exploration and the worlds.
        weights: initial weights to take instead, in the order of `policy/weights.py`:
            (parameters,).

    Raises:
        WorldError: the world does not exist, or does not support the eye.
    """

    def __init__(self, config: TrainConfig, weights: npt.NDArray[np.float64] | None = None) -> None:
        self.config = config
        self.contract = config.contract()
        self._ends = stage_ends(config.worlds, update_rules_for(config).updates)
        self._stage, self._simulation = 0, self._world_of_stage(0)
        self._learning = new_learning(config, weights)
        self._reported = counts(0, 0, 0.0)
        self._begin()

    @property
    def step(self) -> int:
        """Transitions learned from so far."""
        return self._updates * self.config.learner.batched.batch_steps

    @property
    def epsilon(self) -> float:
        """The exploration rate ε now."""
        rules = self._learning.update_rules
        start, end = rules.epsilon_start, rules.epsilon_end
        return linear(self._updates, start, end, rules.epsilon_updates)

    @property
    def weights(self) -> npt.NDArray[np.float64]:
        """The learned weights, in the order of `policy/weights.py`: (parameters,)."""
        return self._learning.state.averaged.astype(np.float64)

    def run(self, steps: int) -> None:
        """Learn from as many roll-outs as fit into `steps` transitions, or from one if none fits.

        Raises:
            UsageError: the weights are no longer finite.
        """
        updates = max(1, steps // self.config.learner.batched.batch_steps)
        while updates > 0:
            left = self._ends[self._stage] - self._updates
            part = updates if left == math.inf else min(updates, math.ceil(left))
            self._learn_in_stage(part)
            updates -= part

    def report(self) -> Report:
        """What happened since the last mark."""
        sum_abs_error = float(self._learning.state.errors.sum())
        dt_s = self._simulation.dt_s
        return report_between(self._reported, self._counts(), sum_abs_error, self.config, dt_s)

    def mark(self) -> None:
        """Let the next report begin here."""
        self._learning.state.errors[:] = 0.0
        self._reported[:] = self._counts()

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        world = {WORLD + name: array for name, array in self._simulation.state().items()}
        own = {name: array.copy() for name, array in self._own().items()}
        return {**own, **world, STAGE: np.array([self._stage])}

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Continue from a state that `arrays` returned.

        Raises:
            UsageError: an array is missing, or of another shape or type.
        """
        restore_arrays(self._own(), arrays)
        self._enter(saved_stage(arrays, len(self._ends)))
        self._simulation.restore(world_arrays(arrays))

    @property
    def _updates(self) -> int:
        """Updates so far."""
        return int(self._learning.state.progress["updates"][0])

    def _learn_in_stage(self, updates: int) -> None:
        """Learn in the present worlds; enter the next ones where their share of the run ends."""
        learning, barrier = self._learning, new_barrier()
        shards = len(learning.state.gradients)
        threads = min(thread_count(), shards)

        # Made beforehand: where one thread fails, the others would wait at the barrier for ever.
        accesses = [self._world_access() for _ in range(threads)]

        def learn_part(first: int, end: int) -> None:
            world = accesses.pop()
            learn(learning, world, barrier, threads, first, end, updates)
            self._simulation.require_nothing_lost(world.held)

        together(learn_part, shards)
        check_finite(learning.state.weights, self.step, self.config)
        stage = stage_at(self._ends, self._updates)
        if stage != self._stage:
            # The next worlds count from zero: what the report has of these becomes negative.
            self._reported["contacts"] -= self._simulation.contacts.sum()
            self._reported["distance_m"] -= self._simulation.distance_m.sum()
            self._enter(stage)
            self._begin()

    def _world_access(self) -> WorldAccess:
        step, held = self._simulation.held_step()
        return WorldAccess(step, held, self._simulation.params.agents.stack)

    def _world_of_stage(self, stage: int) -> Simulation:
        return Simulation(
            self.config.source_of(self.config.worlds[stage]), self.contract, _seeds(self.config)
        )

    def _enter(self, stage: int) -> None:
        """Put the agents into the worlds of a stage, unless they are there."""
        if stage != self._stage:
            self._stage, self._simulation = stage, self._world_of_stage(stage)

    def _counts(self) -> npt.NDArray[np.void]:
        """Transitions of the run; contacts and progress in these worlds: `COUNTS_DTYPE` (1,)."""
        simulation = self._simulation
        return counts(self.step, simulation.contacts.sum(), simulation.distance_m.sum())

    def _own(self) -> Arrays:
        """The arrays that are not the simulation's; buffers of an update are left out."""
        learning = self._learning
        return {
            "weights": learning.state.weights,
            "averaged": learning.state.averaged,
            "errors": learning.state.errors,
            "progress": learning.state.progress,
            "reported": self._reported,
            **{f"moments.{name}": array for name, array in learning.moments._asdict().items()},
            **{f"agents.{name}": array for name, array in learning.agents._asdict().items()},
        }

    def _begin(self) -> None:
        """Sense for the first time in a world; the next roll-out chooses the first actions."""
        agents = self._learning.agents
        self._simulation.sense()
        agents.seen[:] = self._simulation.stacks.reshape(agents.seen.shape)
        agents.held_actions[:] = NOT_CHOSEN


def compile_learner(config: TrainConfig) -> None:
    """Compile the code that a run learns with, unless it is compiled: a call of no update."""
    learning = new_learning(config)
    no_world = WorldAccess(NO_STEP, NOTHING_HELD, np.zeros_like(learning.agents.seen))
    learn(learning, no_world, new_barrier(), 1, 0, 0, 0)


def _seeds(config: TrainConfig) -> npt.NDArray[np.uint64]:
    """Seeds of the agents' training worlds; a run with another seed has others: (agents,)."""
    agents, worlds = config.learner.batched.agents, len(TRAINING_SEEDS)
    numbers = (config.seed % worlds * agents + np.arange(agents)) % worlds
    return all_of(TRAINING_SEEDS)[numbers]
