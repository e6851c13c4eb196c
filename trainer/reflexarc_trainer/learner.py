"""One agent that learns in one endless world: the compiled loop, and its face in Python.

The loop is `reference.learn` with the world inside: act, look, learn, `steps` times over. It is
called for some ten thousand steps at a time; how a run is cut into calls changes nothing, for all
that it needs lies in arrays that a checkpoint carries.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.compiled import compiled
from reflexarc_sim_bridge.kernel import sense_agent, step_agent
from reflexarc_sim_bridge.params import Agents, EyeParams, WorldParams
from reflexarc_sim_bridge.seeds import TRAINING_SEEDS
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import world_named
from reflexarc_trainer.choice import new_stream
from reflexarc_trainer.config import LearnerConfig, TrainConfig
from reflexarc_trainer.online import (
    Floats,
    LearnerState,
    Rules,
    Scratch,
    begin,
    learn_step,
    new_scratch,
    new_state,
)
from reflexarc_trainer.q_network import QNetwork, new_network
from reflexarc_trainer.schedules import linear_epsilon
from reflexarc_trainer.weights import pack, unpack

Arrays = dict[str, npt.NDArray[Any]]

_WORLD = "world."


@dataclass(frozen=True)
class Report:
    """What happened while learning since the last report."""

    mean_abs_td_error: float
    contacts_per_100m: float


class OnlineLearner:
    """A learner at some step of its run.

    Args:
        config: the run; its seed gives the initial weights, the exploration and the world.

    Raises:
        WorldError: there is no such world, or it cannot give what the eye asks for.
    """

    def __init__(self, config: TrainConfig) -> None:
        self.config = config
        self.contract = config.contract()
        seeds = np.array([TRAINING_SEEDS[config.seed % len(TRAINING_SEEDS)]], np.uint64)
        self._simulation = Simulation(world_named(config.world), self.contract, seeds)
        self._rules = rules_for(config.learner, self.contract, config.steps)
        weights = pack(new_network(self.contract, config.learner, config.seed))
        self._state = new_state(self._rules, weights, new_stream(config.seed))
        self._scratch = new_scratch(self._rules)
        self._scratch.retina[:] = self._simulation.sense().ravel()
        begin(self._rules, self._state, self._scratch)

    @property
    def step(self) -> int:
        """Transitions learned from so far."""
        return int(self._state.pending[2])

    @property
    def epsilon(self) -> float:
        """Share of random actions now."""
        rules = self._rules
        return linear_epsilon(
            self.step, rules.epsilon_start, rules.epsilon_end, rules.epsilon_steps
        )

    @property
    def weights(self) -> Floats:
        """The weights now, as one vector (parameters,): a copy."""
        return self._state.weights.copy()

    def network(self) -> QNetwork:
        """The weights now, as a network."""
        return unpack(self._state.weights, self.contract, self.config.learner)

    def run(self, steps: int) -> None:
        """Learn from `steps` more transitions.

        Raises:
            UsageError: the weights are no longer finite.
        """
        drive(
            self._rules,
            self._state,
            self._scratch,
            *self._simulation.params,
            motions_of(self.contract),
            steps,
        )
        if not np.isfinite(self._state.weights).all():
            raise UsageError(
                f"learner: the weights are not finite after {self.step} steps (learner.step = "
                f"{self.config.learner.step!r}, alpha = {self.config.learner.alpha:g}); "
                "use the bounded step or a smaller alpha"
            )

    def report(self) -> Report:
        """What happened since the last report; the next one begins here."""
        td_errors, contacts, step, distance_m = self._state.totals.tolist()
        driven_m = float(self._simulation.distance_m[0])
        report = Report(
            mean_abs_td_error=td_errors / max(1.0, self.step - step),
            contacts_per_100m=100.0 * contacts / max(1e-9, driven_m - distance_m),
        )
        self._state.totals[:] = 0.0, 0.0, self.step, driven_m
        return report

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        world = {_WORLD + name: array for name, array in self._simulation.state().items()}
        return {**self._state._asdict(), **world}

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Go on from what `arrays` gave.

        Raises:
            UsageError: an array is missing or of another shape.
        """
        for name, mine in self._state._asdict().items():
            if name not in arrays or arrays[name].shape != mine.shape:
                raise UsageError(f"checkpoint: {name}: expected shape {mine.shape}; train anew")
            mine[:] = arrays[name]
        world = {k.removeprefix(_WORLD): v for k, v in arrays.items() if k.startswith(_WORLD)}
        self._simulation.restore(world)


def motions_of(contract: PolicyContract) -> Floats:
    """Linear and lateral speed of each action: (actions, 2)."""
    return np.array([(a.linear_mps, a.lateral_mps) for a in contract.actions], np.float64)


def rules_for(learner: LearnerConfig, contract: PolicyContract, steps: int) -> Rules:
    """The constants of a run of `steps` steps."""
    return Rules(
        inputs=contract.retina.frames * contract.retina.size,
        hidden=learner.hidden,
        actions=len(contract.actions),
        sigmoid_output=learner.output == "sigmoid",
        alpha=learner.alpha,
        gamma=learner.gamma,
        trace_decay=learner.trace_decay,
        literal=learner.step == "literal",
        kappa=learner.kappa,
        reward_step=learner.reward_step,
        reward_contact=learner.reward_contact,
        terminal=learner.after_contact == "terminal",
        epsilon_start=learner.epsilon_start,
        epsilon_end=learner.epsilon_end,
        epsilon_steps=learner.epsilon_span * steps,
        held_actions=learner.held_actions,
    )


@compiled
def drive(
    rules: Rules,
    state: LearnerState,
    scratch: Scratch,
    world: WorldParams,
    eye: EyeParams,
    agents: Agents,
    motions_mps: Floats,
    steps: int,
) -> None:
    """Act, look, learn. `motions_mps` is (actions, 2): linear, lateral."""
    for _ in range(steps):
        action = state.pending[0]
        contact = step_agent(world, agents, 0, motions_mps[action, 0], motions_mps[action, 1])
        sense_agent(world, eye, agents, 0, scratch.retina)
        learn_step(rules, state, scratch, contact)
