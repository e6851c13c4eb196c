"""The endless generator: which obstacles there are, for ever, without remembering one.

A chunk is a strip of `CHUNK_M` along x over the whole width. Its obstacles follow from
(generator version, seed, stream, chunk) alone: a Poisson count, then for each obstacle a fixed
block of random numbers, of which number k is a hash of a counter. So chunks can be asked for in
any order, as often as one likes, and an obstacle costs nothing until one of its numbers is looked
at. An obstacle belongs to the chunk of its centre.

The hash is SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators",
OOPSLA 2014): number k of the stream with key z is mix(z + k·γ).
"""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract
from reflexarc_sim_bridge.compiled import compiled
from reflexarc_sim_bridge.params import CHUNK_M, WorldParams, world_params
from reflexarc_sim_bridge.worlds import World

GENERATOR_VERSION = 1
"""Part of every key. Any change to what a seed means takes a new one, and a new reference field."""

OBSTACLE_DTYPE = np.dtype(
    [
        ("x_m", np.float64),
        ("y_m", np.float64),
        ("half_length_m", np.float64),
        ("half_width_m", np.float64),
        ("round", np.bool_),
        ("colour", np.float64),
    ]
)
"""One obstacle: centre, half its extent along x and along y, disc or rectangle, grey value."""

_VERSION = np.uint64(GENERATOR_VERSION)
_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S11, _S27, _S30, _S31 = (np.uint64(shift) for shift in (11, 27, 30, 31))
_UNIT = 2.0**-53

_OBSTACLES = np.uint64(0)
_PLACES = np.uint64(1)

# Number 0 of a chunk is its count; obstacle j has the numbers 1 + 8j to 8 + 8j.
_BLOCK = 8
_DRAW_X, _DRAW_Y, _DRAW_KIND, _DRAW_WIDTH, _DRAW_LENGTH, _DRAW_COLOUR = range(1, 7)


def obstacles_of_chunk(world: World, seed: int, chunk: int) -> npt.NDArray[np.void]:
    """The obstacles of one chunk, for drawing and for tests.

    Args:
        world: the kind of world.
        seed: which world of that kind, 0 to 2⁶⁴ − 1.
        chunk: its index; chunk i spans `CHUNK_M` from i · `CHUNK_M` on.

    Returns:
        Array of `OBSTACLE_DTYPE`: (count,), y within the world's width.
    """
    rows = _listed(world_params(world, PolicyContract()), np.uint64(seed), chunk)
    obstacles = np.empty(len(rows), OBSTACLE_DTYPE)
    for name, column in zip(OBSTACLE_DTYPE.names or (), rows.T, strict=True):
        obstacles[name] = column
    return obstacles


@compiled
def chunk_key(world: WorldParams, seed: np.uint64, chunk: int) -> np.uint64:
    """Key of a chunk's random numbers."""
    return _joined(_world_key(world, seed, _OBSTACLES), np.uint64(chunk))


@compiled
def chunk_count(world: WorldParams, key: np.uint64) -> int:
    """How many obstacles a chunk has: Poisson, its draw inverted by adding up probabilities."""
    draw, count = _uniform(key, np.uint64(0)), 0
    probability = cumulative = world.none_probability
    while draw >= cumulative and cumulative + probability > cumulative:
        count += 1
        probability *= world.mean_count / count
        cumulative += probability
    return count


@compiled
def obstacle_x_m(key: np.uint64, chunk: int, j: int) -> float:
    """Centre along x."""
    return (chunk + _draw(key, j, _DRAW_X)) * CHUNK_M


@compiled
def obstacle_size_m(world: WorldParams, key: np.uint64, j: int) -> tuple[float, float, bool]:
    """Half the extent along x, half the extent along y, and whether it is a disc."""
    width, length = _draw(key, j, _DRAW_WIDTH), _draw(key, j, _DRAW_LENGTH)
    if _draw(key, j, _DRAW_KIND) < world.disc_share:
        radius_m = _between(world.radius_low_m, world.radius_high_m, width)
        return radius_m, radius_m, True
    half_length_m = 0.5 * _between(world.length_low_m, world.length_high_m, length)
    return half_length_m, 0.5 * _between(world.width_low_m, world.width_high_m, width), False


@compiled
def obstacle_y_m(world: WorldParams, key: np.uint64, j: int) -> float:
    """Centre along y: anywhere in a period; with open edges placed by its corner, whole inside."""
    draw = _draw(key, j, _DRAW_Y)
    if world.periodic:
        return draw * world.width_m
    half_width_m = obstacle_size_m(world, key, j)[1]
    return _between(half_width_m, world.width_m - half_width_m, draw)


@compiled
def obstacle_colour(world: WorldParams, key: np.uint64, j: int) -> float:
    """Grey value, 0 to 1."""
    return _between(world.colour_low, world.colour_high, _draw(key, j, _DRAW_COLOUR))


@compiled
def random_place(world: WorldParams, seed: np.uint64, lane: np.uint64, number: np.uint64) -> float:
    """Random number of an agent, in [0, 1): `number` counts, `lane` tells agents apart."""
    return _uniform(_joined(_world_key(world, seed, _PLACES), lane), number)


@compiled
def _listed(world: WorldParams, seed: np.uint64, chunk: int) -> npt.NDArray[np.float64]:
    """A chunk's obstacles as rows, columns as in `OBSTACLE_DTYPE`: (count, 6)."""
    key = chunk_key(world, seed, chunk)
    rows = np.empty((chunk_count(world, key), 6))
    for j in range(len(rows)):
        half_length_m, half_width_m, is_disc = obstacle_size_m(world, key, j)
        rows[j, 0], rows[j, 1] = obstacle_x_m(key, chunk, j), obstacle_y_m(world, key, j)
        rows[j, 2], rows[j, 3] = half_length_m, half_width_m
        rows[j, 4], rows[j, 5] = is_disc, obstacle_colour(world, key, j)
    return rows


@compiled
def _world_key(world: WorldParams, seed: np.uint64, purpose: np.uint64) -> np.uint64:
    stream = (np.uint64(world.stream) << _S11) | purpose
    return _joined(_joined(_mixed(_VERSION * _GAMMA), seed), stream)


@compiled
def _joined(key: np.uint64, part: np.uint64) -> np.uint64:
    """A new key from a key and a number. Two rounds: neighbouring parts share no pattern."""
    return _mixed(key ^ _mixed(part * _GAMMA + _GAMMA))


@compiled
def _draw(key: np.uint64, j: int, which: int) -> float:
    return _uniform(key, np.uint64(j * _BLOCK + which))


@compiled
def _uniform(key: np.uint64, number: np.uint64) -> float:
    """Number `number` of the stream, uniform in [0, 1) with 53 bits."""
    return np.float64(_mixed(key + (number + np.uint64(1)) * _GAMMA) >> _S11) * _UNIT


@compiled
def _mixed(z: np.uint64) -> np.uint64:
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@compiled
def _between(low: float, high: float, draw: float) -> float:
    return low + (high - low) * draw
