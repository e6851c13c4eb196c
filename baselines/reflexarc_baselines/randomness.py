"""Chance that is part of a baseline's memory: one number, from which the next one follows.

A baseline keeps nothing, so its dice are a value of its memory: the same retinas and memories give
the same draws, in a replay as on the robot. It is D. H. Lehmer's generator (1949), into which each
draw stirs what is seen:

    m = 1 + (s + h − 1) mod (p − 1),   s ← a m mod p,   p = 2²⁴ − 3, a prime

and what is drawn is (s − 1) / (p − 1). s is a whole number below 2²⁴, which float32 holds exactly,
and never 0 after a draw. h is a hash of the newest retina: its bytes are the digits of a number to
the base a, modulo p; a dark retina has h = 0. All agents begin with s = 0, and part as soon as two
of them see different things when they draw.
"""

from functools import cache

import numpy as np
import numpy.typing as npt

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import RetinaBatch

PRIME = 2**24 - 3
"""p: the largest prime below 2²⁴."""
MULTIPLIER = 7_138_531
"""a: a primitive root of p, so in the dark no number comes back before all p − 1 had their turn;
of 20,000 drawn ones the best in 2 and 3 dimensions (spectral test: 0.97 of what is possible)."""


def drawn(states: Floats, retinas: RetinaBatch) -> tuple[Floats, Floats]:
    """Draw one number for each agent.

    Args:
        states: s of each agent, 0 at the start: (n,).
        retinas: what they see: uint8 (n, frames, eyes, rays, channels).

    Returns:
        Numbers uniform in [0, 1), and the states for the next draw: (n,) each.
    """
    mixed = 1 + (states.astype(np.int64) + _hashes(retinas) - 1) % (PRIME - 1)
    following = MULTIPLIER * mixed % PRIME
    uniform = (following - 1) / np.float64(PRIME - 1)
    return uniform.astype(np.float32), following.astype(np.float32)


def _hashes(retinas: RetinaBatch) -> npt.NDArray[np.int64]:
    """H of the newest frames: (n,)."""
    newest = retinas[:, -1].reshape(len(retinas), -1).astype(np.int64)
    hashes: npt.NDArray[np.int64] = newest @ _powers(newest.shape[1]) % PRIME
    return hashes


@cache
def _powers(count: int) -> npt.NDArray[np.int64]:
    """a, a², a³, … modulo p: (count,). 2¹⁶ bytes times them sum to less than 2⁴⁸."""
    return np.array([pow(MULTIPLIER, i + 1, PRIME) for i in range(count)], np.int64)
