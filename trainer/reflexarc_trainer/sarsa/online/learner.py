"""One agent that learns in one endless world: the compiled loop, and its face in Python.

The loop is `reference.learn` with the world inside: act, look, learn, `steps` times over. It is
called for some ten thousand steps at a time; how a run is cut into calls changes nothing, for all
that it needs lies in arrays that a checkpoint carries.
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
from reflexarc_trainer.sarsa.learner import (
    WORLD,
    Arrays,
    Report,
    check_finite,
    driven_m,
    restore_arrays,
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
    """A learner at some step of its run.

    Args:
        config: the run; its seed gives the initial weights, the exploration and the world.
        weights: what to begin with instead, in the order of `weights.py`: (parameters,).

    Raises:
        WorldError: there is no such world, or it cannot give what the eye asks for.
    """

    def __init__(self, config: TrainConfig, weights: Floats | None = None) -> None:
        self.config = config
        self.contract = config.contract()
        self._ends = stage_ends(config.worlds, config.steps)
        self._stage, self._simulation = 0, self._world_of_stage(0)
        self._rules = rules_for(config)
        self._sizes = sizes_of(config)
        self._state, self._scratch = new_learning(config, weights)
        self._begin()

    @property
    def step(self) -> int:
        """Transitions learned from so far."""
        return int(self._state.pending[2])

    @property
    def epsilon(self) -> float:
        """Share of random actions now."""
        rules = self._rules
        return linear(self.step, rules.epsilon_start, rules.epsilon_end, rules.epsilon_steps)

    @property
    def weights(self) -> Floats:
        """What has been learned, in the order of `weights.py`: (parameters,)."""
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
            self._drive(part)
            steps -= part

    def report(self) -> Report:
        """What happened since the last mark."""
        td_errors, contacts, step, distance_m = self._state.totals.tolist()
        dt_s, transitions = self._simulation.dt_s, self.step - step
        repeat = self.config.learner.exploration.action_repeat
        contacts = float(self._simulation.contacts[0]) - contacts
        distance_m = float(self._simulation.distance_m[0]) - distance_m
        driven = driven_m(self.config, dt_s, transitions * repeat, distance_m)
        return Report(
            mean_abs_error=td_errors / max(1.0, transitions),
            contacts_per_100m=100.0 * contacts / driven,
        )

    def mark(self) -> None:
        """The next report begins here."""
        world = self._simulation
        self._state.totals[:] = 0.0, world.contacts[0], self.step, world.distance_m[0]

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        world = {WORLD + name: array for name, array in self._simulation.state().items()}
        return {**self._state._asdict(), **world, SIZES: np.array(self._sizes)}

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Go on from what `arrays` gave.

        Raises:
            UsageError: an array is missing, or of another shape or network.
        """
        # Networks of other sizes may fill up to vectors of the same length.
        if not np.array_equal(arrays.get(SIZES, ()), self._sizes):
            raise UsageError(f"checkpoint: weights: expected shape {self._sizes}; train anew")
        restore_arrays(self._state._asdict(), arrays)
        self._enter(stage_at(self._ends, self.step))
        self._simulation.restore(world_arrays(arrays))

    def _drive(self, steps: int) -> None:
        """Learn, and go on to the next world where this one's part is over."""
        self._call(False, steps)
        check_finite(self._state.weights, self.step, self.config)
        stage = stage_at(self._ends, self.step)
        if stage != self._stage:
            # The new one counts from zero.
            self._state.totals[1] -= self._simulation.contacts[0]
            self._state.totals[3] -= self._simulation.distance_m[0]
            self._enter(stage)
            self._begin()

    def _world_of_stage(self, stage: int) -> Simulation:
        seeds = np.array([TRAINING_SEEDS[self.config.seed % len(TRAINING_SEEDS)]], np.uint64)
        return Simulation(self.config.worlds[stage].source(), self.contract, seeds)

    def _enter(self, stage: int) -> None:
        """Put the agent into the world of a stage, unless it is there."""
        if stage != self._stage:
            self._stage, self._simulation = stage, self._world_of_stage(stage)

    def _begin(self) -> None:
        """Look for the first time in a world, and choose the first action; nothing led here."""
        self._state.trace[:] = 0.0
        self._simulation.sense()
        self._call(True, 0)

    def _call(self, begins: bool, steps: int) -> None:
        step, held = self._simulation.held_step()
        stack = self._simulation.params.agents.stack[0]
        drive(self._rules, self._state, self._scratch, step, held, stack, begins, steps)
        self._simulation.require_nothing_lost(held)


def sizes_of(config: TrainConfig) -> tuple[int, int, int]:
    """Inputs, hidden units, actions."""
    contract = config.contract()
    inputs = contract.retina.frames * contract.retina.size
    return inputs, config.network.hidden[0], len(contract.actions)


def new_learning(
    config: TrainConfig, weights: Floats | None = None
) -> tuple[LearnerState, Scratch]:
    """State and buffers before the first step; `weights` as for `OnlineLearner`."""
    inputs, hidden, actions = sizes_of(config)
    precision = config.learner.online.precision
    plain = (initial_weights(config) if weights is None else weights).astype(precision)
    state = new_state(to_online(plain, inputs, hidden, actions), inputs, new_streams(config.seed))
    curve = input_curve(config.network, precision)
    return state, new_scratch(state, hidden, actions, curve)


def compile_learner(config: TrainConfig) -> None:
    """Compile what a run learns with, unless that is done: it learns for no step."""
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
    )
