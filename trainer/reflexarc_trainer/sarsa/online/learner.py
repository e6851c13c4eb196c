"""The online learner: one agent that learns in one endless world, by the compiled `update.drive`.

It does what `reference.learn` does, with the world inside the compiled loop. The loop runs for some
ten thousand transitions per call; how a run is divided into calls does not change its results, for
all that it depends on is in arrays, which a checkpoint carries.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step_pointer import NO_STEP, NOTHING_HELD
from reflexarc_sim_bridge.worlds.seeds import TRAINING_SEEDS
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import stage_at, stage_ends
from reflexarc_trainer.sarsa.exploration import new_streams
from reflexarc_trainer.sarsa.initial_weights import initial_weights
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
from reflexarc_trainer.sarsa.network_shape import input_curve
from reflexarc_trainer.sarsa.online.state import (
    Floats,
    LearnerState,
    Rules,
    Scratch,
    new_scratch,
    new_state,
)
from reflexarc_trainer.sarsa.online.traces import STEP_RULES
from reflexarc_trainer.sarsa.online.update import drive
from reflexarc_trainer.sarsa.online.weight_rows import from_online, to_online
from reflexarc_trainer.sarsa.schedules import linear
from reflexarc_trainer.sarsa.units import UNITS

SIZES = "sizes"
"""Name, in a checkpoint, of the numbers of inputs, hidden units and actions."""


class OnlineLearner:
    """A learner at some step of its run; see `Learner`.

    Args:
        config: the run; its seed gives the initial weights, the exploration and the world.
        weights: initial weights to take instead, in the order of `policy/weights.py`:
            (parameters,).

    Raises:
        WorldError: the world does not exist, or does not support the eye.
    """

    def __init__(self, config: TrainConfig, weights: Floats | None = None) -> None:
        self.config = config
        self.contract = config.contract()
        self._ends = stage_ends(config.worlds, config.steps)
        self._stage, self._simulation = 0, self._world_of_stage(0)
        self._rules = rules_for(config)
        self._sizes = sizes_of(config)
        self._state, self._scratch = new_learning(config, weights)
        self._reported = counts(0, 0, 0.0)
        self._begin()

    @property
    def step(self) -> int:
        """Transitions learned from so far."""
        return int(self._state.progress["step"][0])

    @property
    def epsilon(self) -> float:
        """The exploration rate ε now."""
        rules = self._rules
        return linear(self.step, rules.epsilon_start, rules.epsilon_end, rules.epsilon_steps)

    @property
    def weights(self) -> Floats:
        """The learned weights, in the order of `policy/weights.py`: (parameters,)."""
        averaged = self.config.learner.averaged_weights > 0.0
        chosen = self._state.averaged if averaged else self._state.weights
        return from_online(chosen, *self._sizes).astype(np.float64)

    def run(self, steps: int) -> None:
        """Learn from `steps` more transitions.

        Raises:
            UsageError: the weights are no longer finite.
        """
        while steps > 0:
            left = self._ends[self._stage] - self.step
            part = steps if left == math.inf else min(steps, math.ceil(left))
            self._learn_in_stage(part)
            steps -= part

    def report(self) -> Report:
        """What happened since the last mark."""
        sum_abs_error = float(self._state.progress["sum_abs_error"][0])
        dt_s = self._simulation.dt_s
        return report_between(self._reported, self._counts(), sum_abs_error, self.config, dt_s)

    def mark(self) -> None:
        """Let the next report begin here."""
        self._state.progress["sum_abs_error"] = 0.0
        self._reported[:] = self._counts()

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        world = {WORLD + name: array for name, array in self._simulation.state().items()}
        own = {SIZES: np.array(self._sizes), STAGE: np.array([self._stage])}
        return {**self._own(), **world, **own}

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Continue from a state that `arrays` returned.

        Raises:
            UsageError: an array is missing, or of another shape, type or network.
        """
        # Vectors of two networks may have the same length, as their rows are filled up.
        sizes = tuple(arrays.get(SIZES, np.zeros(0, np.int64)).tolist())
        if sizes != self._sizes:
            raise UsageError(
                f"checkpoint: weights: expected shape {self._sizes}, got {sizes}; train anew"
            )
        restore_arrays(self._own(), arrays)
        self._enter(saved_stage(arrays, len(self._ends)))
        self._simulation.restore(world_arrays(arrays))

    def _own(self) -> Arrays:
        """The arrays that are not the simulation's."""
        return {**self._state._asdict(), "reported": self._reported}

    def _learn_in_stage(self, steps: int) -> None:
        """Learn in the present world, and enter the next one where its share of the run ends."""
        self._call(False, steps)
        check_finite(self._state.weights, self.step, self.config)
        stage = stage_at(self._ends, self.step)
        if stage != self._stage:
            # The next world counts from zero: what the report has of this one becomes negative.
            self._reported["contacts"] -= self._simulation.contacts[0]
            self._reported["distance_m"] -= self._simulation.distance_m[0]
            self._enter(stage)
            self._begin()

    def _world_of_stage(self, stage: int) -> Simulation:
        seeds = np.array([TRAINING_SEEDS[self.config.seed % len(TRAINING_SEEDS)]], np.uint64)
        world = self.config.source_of(self.config.worlds[stage])
        return Simulation(world, self.contract, seeds)

    def _enter(self, stage: int) -> None:
        """Put the agent into the world of a stage, unless it is there."""
        if stage != self._stage:
            self._stage, self._simulation = stage, self._world_of_stage(stage)

    def _counts(self) -> npt.NDArray[np.void]:
        """Transitions of the run; contacts and progress in this world: `COUNTS_DTYPE` (1,)."""
        return counts(self.step, self._simulation.contacts[0], self._simulation.distance_m[0])

    def _begin(self) -> None:
        """Sense for the first time in a world, and choose an action; no trace leads here."""
        self._state.trace[:] = 0.0
        self._simulation.sense()
        self._call(True, 0)

    def _call(self, begins: bool, steps: int) -> None:
        step, held = self._simulation.held_step()
        stack = self._simulation.params.agents.stack[0]
        try:
            drive(self._rules, self._state, self._scratch, step, held, stack, begins, steps)
        finally:  # also after an interrupt: what was learned so far is about to be saved
            self._simulation.require_nothing_lost(held)


def sizes_of(config: TrainConfig) -> tuple[int, int, int]:
    """Numbers of inputs, hidden units and actions."""
    contract = config.contract()
    inputs = contract.retina.frames * contract.retina.size
    return inputs, config.network.hidden[0], len(contract.actions)


def new_learning(
    config: TrainConfig, weights: Floats | None = None
) -> tuple[LearnerState, Scratch]:
    """State and buffers before the first transition; `weights` as for `OnlineLearner`."""
    inputs, hidden, actions = sizes_of(config)
    precision = config.learner.online.precision
    plain = (initial_weights(config) if weights is None else weights).astype(precision)
    state = new_state(to_online(plain, inputs, hidden, actions), inputs, new_streams(config.seed))
    curve = input_curve(config.network, precision)
    return state, new_scratch(state, hidden, actions, curve)


def compile_learner(config: TrainConfig) -> None:
    """Compile the code that a run learns with, unless it is compiled: a call of no transition."""
    rules, (state, scratch) = rules_for(config), new_learning(config)
    drive(
        rules,
        state,
        scratch,
        NO_STEP,
        NOTHING_HELD,
        np.zeros(sizes_of(config)[0], np.uint8),
        False,
        0,
    )


def rules_for(config: TrainConfig) -> Rules:
    """The constants of a run."""
    learner, explore, online = config.learner, config.learner.exploration, config.learner.online
    return Rules(
        hidden=config.network.hidden[0],
        units=UNITS[config.network.units],
        output=UNITS[config.network.output],
        step=STEP_RULES[online.step],
        alpha=online.alpha,
        alpha_end=online.alpha * online.alpha_end,
        kappa=online.kappa,
        steps=float(config.steps),
        gamma=learner.gamma,
        trace_decay=learner.trace_decay,
        expected=learner.target == "expected",
        reward_step=learner.reward_step,
        reward_contact=learner.reward_contact,
        centring=learner.reward_centring,
        averaging=learner.averaged_weights,
        terminal=learner.after_contact == "terminal",
        epsilon_start=explore.epsilon_start,
        epsilon_end=explore.epsilon_end,
        epsilon_steps=explore.epsilon_span * config.steps,
        held_actions=explore.held_actions,
        action_repeat=explore.action_repeat,
        margin=explore.margin,
        least_lead=explore.least_lead,
        reward_switch=learner.reward_switch,
    )
