"""Scenes and the clock that the benchmarks of the world share."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions
from reflexarc_runtime.contract.eye import BeamRule
from reflexarc_sim_bridge.native.threads import shared
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE, PLACE
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, Scatter
from reflexarc_sim_bridge.worlds.reference_contract import (
    WORLD_NAME,
    reference_contract,
    reference_retina,
)
from reflexarc_sim_bridge.worlds.seeds import training_seeds
from reflexarc_sim_bridge.worlds.shapes import Curves, Rectangles, Shape
from reflexarc_sim_bridge.worlds.world import World

MODES = {"look": LOOK, "move": MOVE, "both": MOVE + LOOK}
HELD_STEPS = 3
HALF_TURN_RAD = 3.141592653589793

Advance = Callable[[Actions], object]
"""One step of all agents: (n,)."""

SHAPES: dict[str, tuple[Shape, ...]] = {
    "upright": (Rectangles(),),
    "turned": (Rectangles(turned_rad=(0.0, HALF_TURN_RAD)),),
    "curves": (Curves(),),
    "turned and curves": (
        Rectangles(turned_rad=(0.0, HALF_TURN_RAD), share=0.5),
        Curves(share=0.5),
    ),
}
"""What the fields below can be filled with."""


@dataclass(frozen=True)
class Scene:
    """A field and the agents in it."""

    agents: int = 4096
    density_per_m2: float = 0.50
    rays: int = 16
    samples: int = 1
    """Directions that a ray shows the mean of."""
    shapes: str = "upright"
    """One of SHAPES."""
    x_m: float = 0.0
    """Where the agents begin."""

    def simulation(self) -> Simulation:
        """Agents in the worlds of training seeds."""
        retina = replace(
            reference_retina(),
            rays=self.rays,
            samples=self.samples,
            beams=BeamRule.NEAREST_BEAM,  # whose samples are blended: the dearer of the two
        )
        contract = reference_contract(retina)
        simulation = Simulation(self.world(), contract, training_seeds(self.agents))
        if self.x_m:
            _carry_to(simulation, self.x_m)
        return simulation

    def world(self) -> World:
        """The reference field with these obstacles."""
        field = world_named(WORLD_NAME)
        assert isinstance(field, World), "the reference field is one world"
        layer = field.layers[0]
        assert isinstance(layer, Scatter), "the reference field is a scatter"
        shapes = SHAPES[self.shapes]
        layer = replace(layer, density_per_m2=self.density_per_m2, shapes=shapes)
        return replace(field, layers=(layer,))


def actions_of(policy: str, steps: int, agents: int) -> npt.NDArray[np.int64]:
    """What a `blind` (never steering) or `random` (held) policy does: (steps, agents)."""
    if policy == "blind":
        return np.zeros((steps, agents), np.int64)
    drawn = np.random.default_rng(0).integers(0, 3, (-(-steps // HELD_STEPS), agents))
    return np.repeat(drawn, HELD_STEPS, axis=0)[:steps]


def advancing(simulation: Simulation, tasks: int = MODES["both"]) -> Advance:
    """Let all agents move, or look, or both in one pass, on `threads.thread_count()` threads."""
    met, n = np.zeros(len(simulation), np.bool_), len(simulation)
    return lambda actions: shared(partial(simulation.advance, actions, met, tasks), n)


def elapsed_s(advance: Advance, actions: npt.NDArray[np.int64]) -> float:
    """Time that all steps take."""
    begun_s = time.perf_counter()
    for row in actions:
        advance(row)
    return time.perf_counter() - begun_s


def rounds_s(
    ways: dict[str, Advance], actions: npt.NDArray[np.int64], rounds: int
) -> dict[str, npt.NDArray[np.float64]]:
    """Seconds of each way in each round, the ways in turn: other work disturbs all alike."""
    for way in ways.values():
        way(actions[0])  # compiles, or warms up
    times = [[elapsed_s(way, actions) for way in ways.values()] for _ in range(rounds)]
    return dict(zip(ways, np.array(times).T, strict=True))


def _carry_to(simulation: Simulation, x_m: float) -> None:
    simulation.params.agents.state["cell_x"] = int(x_m / CHUNK_M)
    advancing(simulation, PLACE)(np.zeros(len(simulation), np.int64))
