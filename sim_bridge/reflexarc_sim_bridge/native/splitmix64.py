"""Random numbers that are a function of a key and a counter: asked for in any order, on any thread.

SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014):
number k of the stream with key z is mix(z + k·γ). Half a number, 32 bits, is enough for a place
within a chunk (0.6 nm) or a size.
"""

import math

import numpy as np

from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S11, _S27, _S30, _S31, _S32 = (np.uint64(shift) for shift in (11, 27, 30, 31, 32))
_LOW = np.uint64(0xFFFFFFFF)
_UNIT, _HALF_UNIT = 2.0**-53, 2.0**-32


@compiled_inline
def joined(key: np.uint64, part: np.uint64) -> np.uint64:
    """A new key from a key and a number. Two rounds: neighbouring parts share no pattern."""
    return mixed(key ^ mixed(part * _GAMMA + _GAMMA))


@compiled_inline
def number(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Number `counter` of the stream: 64 bits."""
    return mixed(advanced(key, counter))


@compiled_inline
def advanced(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Where number `counter` of the stream comes from: `mixed` of it is the number.

    `advanced(advanced(key, m), n)` is `advanced(key, m + n + 1)`.
    """
    return key + (counter + np.uint64(1)) * _GAMMA


@compiled_inline
def uniform(bits: np.uint64) -> float:
    """A number of 64 bits as one in [0, 1), with 53 bits."""
    return np.float64(bits >> _S11) * _UNIT


@compiled_inline
def first_half(bits: np.uint64) -> float:
    """The upper half of a number as one in [0, 1), with 32 bits."""
    return np.float64(bits >> _S32) * _HALF_UNIT


@compiled_inline
def second_half(bits: np.uint64) -> float:
    """The lower half of a number as one in [0, 1), with 32 bits."""
    return np.float64(bits & _LOW) * _HALF_UNIT


@compiled_inline
def between(low: float, high: float, draw: float) -> float:
    """A draw in [0, 1) as one between two bounds."""
    return low + (high - low) * draw


@compiled_inner
def normal(bits: np.uint64) -> float:
    """A standard normal number from 64 bits (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log1p(-first_half(bits)))
    return radius * math.cos(2.0 * math.pi * second_half(bits))


@compiled_inline
def mixed(z: np.uint64) -> np.uint64:
    """A number of 64 bits that looks like no function of `z`."""
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)
