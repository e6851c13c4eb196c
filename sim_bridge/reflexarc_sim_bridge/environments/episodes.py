"""Episodes of the Gymnasium environments: their worlds, their rewards, their ends.

The first episode of a seed is in the world of that seed, so that a seed names the same world here
as everywhere else. Those after it are in worlds drawn from the seed: number k is the k-th draw of
SplitMix64 (Steele, Lea and Flood, OOPSLA 2014), less its lowest bit, so that it is below 2⁶³ and
never a test seed (`seeds.py`). One environment and many of the same seeds meet the same worlds.
"""

from collections.abc import Sequence

import gymnasium
import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.world import AfterContact, WorldSource

EPISODE_STEPS = 1000
"""After so many steps an episode is truncated, unless told otherwise."""
STEP_REWARD = 0.1
"""For a step without contact (the paper, section 4.2)."""
CONTACT_REWARD = -1.0
"""For a step with one (the same)."""

INFO = ("x_m", "y_m", "distance_m", "contacts")
"""What `info` holds about the current episode of an agent."""

_GAMMA = np.uint64(0x9E3779B97F4A7C15)

Seeds = npt.NDArray[np.uint64]
Indices = npt.NDArray[np.int64]


class WorldSequence:
    """The seed of the next world for each of n environments."""

    def __init__(self, environments: int) -> None:
        self._seeds = np.zeros(environments, np.uint64)
        self._episodes = np.zeros(environments, np.int64)
        self._is_seeded = np.zeros(environments, np.bool_)

    def seed(self, which: Indices, seeds: Seeds) -> None:
        """Begin the sequences of some environments anew: (k,) and (k,)."""
        self._seeds[which], self._episodes[which], self._is_seeded[which] = seeds, 0, True

    def next(self, which: Indices, generator: np.random.Generator) -> Seeds:
        """Seeds of the next worlds of some environments: (k,) → (k,).

        An environment that was never given a seed draws one from the generator.
        """
        unseeded = which[~self._is_seeded[which]]
        self.seed(unseeded, generator.integers(1 << 63, size=len(unseeded), dtype=np.uint64))
        episodes = self._episodes[which]
        self._episodes[which] += 1
        first = self._seeds[which]
        later = _mixed(_mixed(first) + episodes.astype(np.uint64) * _GAMMA) >> np.uint64(1)
        return np.where(episodes == 0, first, later)


def checked_seeds(seeds: Sequence[int]) -> Seeds:
    """Seeds as an array: (n,).

    Raises:
        WorldError: one of them is not a seed.
    """
    for seed in seeds:
        if not 0 <= seed < 1 << 64:
            raise WorldError(f"seed: expected 0 to 2⁶⁴ − 1, got {seed}")
    return np.array(seeds, np.uint64)


def the_world(world: WorldSource | str) -> WorldSource:
    """A world, or the one of that name or file.

    Raises:
        WorldError: no such world, or a file that describes no valid world.
    """
    return world_named(world) if isinstance(world, str) else world


def ends_at_contact(world: WorldSource) -> bool:
    """Whether a contact ends the episode; else it only costs, and the task goes on."""
    return world.drawn(0).chassis.after_contact is AfterContact.TERMINATE


def observation_space(contract: PolicyContract) -> gymnasium.Space[npt.NDArray[np.uint8]]:
    """What the policy sees, flat: uint8 (frames · eyes · rays · channels,)."""
    values = contract.retina.frames * contract.retina.size
    return gymnasium.spaces.Box(0, 255, (values,), np.uint8)


def action_space(contract: PolicyContract) -> gymnasium.spaces.Discrete:
    """An index into the contract's actions."""
    return gymnasium.spaces.Discrete(len(contract.actions))


def _mixed(z: Seeds) -> Seeds:
    """The output function of SplitMix64; arrays wrap around without a warning."""
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))
