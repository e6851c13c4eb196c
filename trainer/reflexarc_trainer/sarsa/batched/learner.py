"""Many agents that learn together, each in an endless world of its own: the face in Python."""

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
from reflexarc_trainer.sarsa.batched.barrier import new_gate
from reflexarc_trainer.sarsa.batched.optimiser import new_moments
from reflexarc_trainer.sarsa.batched.rollout import NOT_CHOSEN, Manner, Pending, Place, new_rollout
from reflexarc_trainer.sarsa.batched.update import Learning, Pace, Sums, learn
from reflexarc_trainer.sarsa.exploration import new_streams
from reflexarc_trainer.sarsa.initial_weights import initial_weights
from reflexarc_trainer.sarsa.learner import (
    WORLD,
    Arrays,
    Report,
    check_finite,
    driven_m,
    restore_arrays,
    world_arrays,
)
from reflexarc_trainer.sarsa.network_shape import input_curve, layers_for
from reflexarc_trainer.sarsa.schedules import linear


class BatchedLearner:
    """A learner at some step of its run.

    Args:
        config: the run; its seed gives the initial weights, the exploration and the worlds.
        weights: what to begin with instead, in the order of `weights.py`: (parameters,).

    Raises:
        WorldError: there is no such world, or it cannot give what the eye asks for.
    """

    def __init__(self, config: TrainConfig, weights: npt.NDArray[np.float64] | None = None) -> None:
        self.config = config
        self.contract = config.contract()
        self._ends = stage_ends(config.worlds, pace_of(config).updates)
        self._stage, self._simulation = 0, self._world_of_stage(0)
        self._learning = new_learning(config, weights)
        self._reported = np.zeros(3)  # steps, contacts and distance_m at the last report
        self._begin()

    @property
    def step(self) -> int:
        """Transitions learned from so far."""
        return int(self._learning.sums.progress[0]) * self.config.learner.batched.batch_steps

    @property
    def epsilon(self) -> float:
        """Share of random actions now."""
        pace, updates = self._learning.pace, self._learning.sums.progress[0]
        return linear(updates, pace.epsilon_start, pace.epsilon_end, pace.epsilon_updates)

    @property
    def weights(self) -> npt.NDArray[np.float64]:
        """What has been learned, in the order of `weights.py`: (parameters,)."""
        return self._learning.sums.averaged.astype(np.float64)

    def run(self, steps: int) -> None:
        """Learn from the roll-outs that fit into `steps` transitions, from one at least.

        Raises:
            UsageError: the weights are no longer finite.
        """
        updates = max(1, steps // self.config.learner.batched.batch_steps)
        while updates > 0:
            left = self._ends[self._stage] - self._learning.sums.progress[0]
            part = updates if left == math.inf else min(updates, math.ceil(left))
            self._update(part)
            updates -= part

    def report(self) -> Report:
        """What happened since the last mark."""
        steps, contacts, distance_m = self._counts() - self._reported
        dt_s, repeat = self._simulation.dt_s, self.config.learner.exploration.action_repeat
        driven = driven_m(self.config, dt_s, steps * repeat, distance_m)
        return Report(
            mean_abs_error=float(self._learning.sums.errors.sum()) / max(1.0, steps),
            contacts_per_100m=100.0 * contacts / driven,
        )

    def mark(self) -> None:
        """The next report begins here."""
        self._learning.sums.errors[:] = 0.0
        self._reported[:] = self._counts()

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        world = {WORLD + name: array for name, array in self._simulation.state().items()}
        return {**{name: array.copy() for name, array in self._own().items()}, **world}

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Go on from what `arrays` gave.

        Raises:
            UsageError: an array is missing or of another shape.
        """
        restore_arrays(self._own(), arrays)
        self._enter(stage_at(self._ends, self._learning.sums.progress[0]))
        self._simulation.restore(world_arrays(arrays))

    def _update(self, updates: int) -> None:
        """Learn, and go on to the next world where this one's part is over."""
        learning, gate = self._learning, new_gate()
        shards = len(learning.sums.gradients)
        threads = min(thread_count(), shards)

        def learn_part(first: int, end: int) -> None:
            step, held = self._simulation.held_step()
            place = Place(step, held, self._simulation.params.agents.stack)
            learn(learning, place, gate, threads, first, end, updates)
            self._simulation.require_nothing_lost(held)

        together(learn_part, shards)
        check_finite(learning.sums.weights, self.step, self.config)
        stage = stage_at(self._ends, learning.sums.progress[0])
        if stage != self._stage:
            self._reported[1:] -= self._counts()[1:]  # the new world counts from zero
            self._enter(stage)
            self._begin()

    def _world_of_stage(self, stage: int) -> Simulation:
        return Simulation(self.config.worlds[stage].source(), self.contract, _seeds(self.config))

    def _enter(self, stage: int) -> None:
        """Put the agents into the world of a stage, unless they are there."""
        if stage != self._stage:
            self._stage, self._simulation = stage, self._world_of_stage(stage)

    def _counts(self) -> npt.NDArray[np.float64]:
        """Steps, and contacts and distance_m in this world: (3,)."""
        simulation = self._simulation
        return np.array([self.step, simulation.contacts.sum(), simulation.distance_m.sum()])

    def _own(self) -> Arrays:
        learning = self._learning
        return {
            "weights": learning.sums.weights,
            "averaged": learning.sums.averaged,
            "errors": learning.sums.errors,
            "progress": learning.sums.progress,
            "reported": self._reported,
            **{f"moments.{name}": array for name, array in learning.moments._asdict().items()},
            **{f"pending.{name}": array for name, array in learning.pending._asdict().items()},
        }

    def _begin(self) -> None:
        """Look for the first time in a world."""
        pending = self._learning.pending
        self._simulation.sense()
        pending.seen[:] = self._simulation.stacks.reshape(pending.seen.shape)
        pending.held[:] = NOT_CHOSEN


def compile_learner(config: TrainConfig) -> None:
    """Compile what a run learns with, unless that is done: it learns for no update."""
    learning = new_learning(config)
    nowhere = Place(NO_STEP, NOTHING_HELD, np.zeros_like(learning.pending.seen))
    learn(learning, nowhere, new_gate(), 1, 0, 0, 0)


def new_learning(config: TrainConfig, weights: npt.NDArray[np.float64] | None = None) -> Learning:
    """Everything that an update needs, before the first one.

    Args:
        config: the run.
        weights: to begin with; by default those that the seed gives: (parameters,).
    """
    batched, contract = config.learner.batched, config.contract()
    shards, columns = batched.agents // batched.shard_agents, batched.shard_agents
    layers, dtype = layers_for(config.network, contract), np.dtype(batched.precision)
    weights = initial_weights(config) if weights is None else weights
    weights = weights.astype(dtype)
    return Learning(
        layers=layers,
        manner=_manner(config),
        pace=pace_of(config),
        pending=Pending(
            seen=np.zeros((batched.agents, int(layers.sizes[0])), np.uint8),
            action=np.zeros(batched.agents, np.int64),
            held=np.full(batched.agents, NOT_CHOSEN),
            met=np.zeros(batched.agents, np.bool_),
            streams=new_streams(config.seed, batched.agents),
        ),
        rollout=new_rollout(shards, batched.rollout_steps, columns, layers, dtype),
        sums=Sums(
            weights=weights,
            averaged=weights.copy(),
            back=np.zeros((shards, layers.computed, columns), dtype),
            gradients=np.zeros((shards, len(weights)), dtype),
            errors=np.zeros(shards),
            progress=np.zeros(2),
        ),
        moments=new_moments(len(weights), dtype),
    )


def pace_of(config: TrainConfig) -> Pace:
    """The course of a run."""
    learner, batched, explore = config.learner, config.learner.batched, config.learner.exploration
    updates = config.steps / batched.batch_steps
    return Pace(
        updates=updates,
        epochs=batched.epochs,
        minibatches=batched.minibatches,
        learning_rate=batched.learning_rate,
        learning_rate_end=batched.learning_rate_end,
        max_gradient_norm=batched.max_gradient_norm,
        rectified=batched.optimiser == "radam",
        epsilon_start=explore.epsilon_start,
        epsilon_end=explore.epsilon_end,
        epsilon_updates=explore.epsilon_span * updates,
        centring=learner.reward_centring,
        averaging=learner.averaged_weights,
    )


def _manner(config: TrainConfig) -> Manner:
    learner = config.learner
    return Manner(
        curve=input_curve(config.network, learner.batched.precision),
        gamma=learner.gamma,
        trace_decay=learner.trace_decay,
        expected=learner.target == "expected",
        greedy=learner.target == "greedy",
        terminal=learner.after_contact == "terminal",
        reward_step=learner.reward_step,
        reward_contact=learner.reward_contact,
        held_actions=learner.exploration.held_actions,
        action_repeat=learner.exploration.action_repeat,
    )


def _seeds(config: TrainConfig) -> npt.NDArray[np.uint64]:
    """Training worlds, other ones for another seed: (agents,)."""
    agents, worlds = config.learner.batched.agents, len(TRAINING_SEEDS)
    numbers = (config.seed % worlds * agents + np.arange(agents)) % worlds
    return all_of(TRAINING_SEEDS)[numbers]
