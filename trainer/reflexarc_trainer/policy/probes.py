"""What an export is checked with: retinas, memories, and sequences of retinas.

Recorded retinas come first, then the ends of the scale, then noise. Memories are those that the
policy reaches by itself, and random ones.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Memories, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.golden_check import Graph, start_of
from reflexarc_runtime.sensing.ray_values import FULL_SCALE

PARITY_RETINAS = 512
SEQUENCE_STEPS = 20
_ROLLOUTS = 32
_ROLLOUT_STEPS = 40


@dataclass(frozen=True)
class Probes:
    """A batch of inputs for a policy."""

    retinas: RetinaBatch
    """uint8 (n, frames, eyes, rays, channels)."""
    memories: Memories | None
    """Float32 (n, size); None without a memory."""


def probe_retinas(contract: PolicyContract, recorded: RetinaBatch | None) -> RetinaBatch:
    """Recorded retinas, the darkest, the brightest, and random ones."""
    shape = contract.retina.stack_shape
    generator = np.random.default_rng(0)
    noise = generator.integers(0, 256, (PARITY_RETINAS, *shape), np.uint8)
    sparse = noise * (generator.random(noise.shape) < 0.3)
    ends = np.stack([np.zeros(shape, np.uint8), np.full(shape, FULL_SCALE, np.uint8)])
    seen = np.empty((0, *shape), np.uint8) if recorded is None else recorded[:PARITY_RETINAS]
    if seen.shape[1:] != shape:
        raise PolicyError(f"recorded retinas: expected (n, {shape}), got {seen.shape}")
    return np.concatenate([seen, ends, noise, sparse.astype(np.uint8)])


def probe_memories(contract: PolicyContract, reached: Memories, count: int) -> Memories:
    """Memories of all kinds, in turn: the start value, random in [−1, 1], and reached ones.

    Args:
        contract: what the policy is.
        reached: memories that it came to: float32 (m, size).
        count: how many: float32 (count, size).
    """
    generator = np.random.default_rng(1)
    memories = generator.uniform(-1.0, 1.0, (count, contract.state.size)).astype(np.float32)
    memories[::2] = reached[generator.integers(0, len(reached), len(memories[::2]))]
    memories[::7] = contract.state.start_value
    return memories


def reached_memories(graph: Graph, contract: PolicyContract) -> Memories:
    """Memories that the policy comes to from its start value: float32 (sequences · steps, size)."""
    sequences = [_smooth(contract, _ROLLOUT_STEPS, seed) for seed in range(_ROLLOUTS - 1)]
    sequences.append(_dark_and_bright(contract, _ROLLOUT_STEPS))
    memories, reached = start_of(contract, _ROLLOUTS), []
    for retinas in np.stack(sequences, axis=1):
        memories = graph.run(retinas, memories)[2]
        assert memories is not None
        reached.append(memories)
    return np.concatenate(reached)


def golden_sequences(contract: PolicyContract) -> list[RetinaBatch]:
    """Sequences to be reproduced at load: a smooth one, and one of dark and bright."""
    if not contract.state.size:
        return []
    return [_smooth(contract, SEQUENCE_STEPS, 1000), _dark_and_bright(contract, SEQUENCE_STEPS)]


def _smooth(contract: PolicyContract, steps: int, seed: int) -> RetinaBatch:
    """Every ray swings between dark and bright, each with a phase and a speed of its own."""
    generator = np.random.default_rng(seed)
    phase, speed = (generator.uniform(0.0, top, contract.retina.stack_shape) for top in (6.3, 0.6))
    angles = phase + speed * np.arange(steps).reshape(-1, 1, 1, 1, 1)
    swing: npt.NDArray[np.float64] = (0.5 + 0.5 * np.sin(angles)) * FULL_SCALE
    return np.rint(swing).astype(np.uint8)


def _dark_and_bright(contract: PolicyContract, steps: int) -> RetinaBatch:
    """All dark, then all bright, five steps each, in turn."""
    levels = np.where(np.arange(steps) // 5 % 2, FULL_SCALE, 0).astype(np.uint8)
    return np.tile(levels.reshape(-1, 1, 1, 1, 1), (1, *contract.retina.stack_shape))
