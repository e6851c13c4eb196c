"""The evolved spiking network: ten neurons between sixteen receptors and two wheels.

Source: D. Floreano and C. Mattiussi, *Evolution of spiking neural controllers for autonomous
vision-based robots*, 2001; constants as two re-implementations have them, kernels after Gerstner's
spike response model. With s milliseconds since a spike,

    u_i = Σ_j w_ij Σ ε(s) + Σ η(s)      over all spikes of the sources j, and over its own
    ε(s) = e^(−(s − Δ)/τ_m) (1 − e^(−(s − Δ)/τ_s)) for s > Δ,   η(s) = −e^(−s/τ_m) for s > 0

and a neuron fires where u_i > 0.1; τ_m = 4 ms, τ_s = 10 ms, Δ = 2 ms. A genome has 10 rows of 29
bits: the sign of the neuron's own effect on others, then from which of 10 neurons and 18 receptors
it takes a connection of weight 1. A receptor fires with the probability |I_{i−1} − 2 I_i +
I_{i+1}| / 2 a millisecond. The last four neurons drive the wheels, push and pull; a wheel's speed
is the difference of their spikes over the last 20 of 100 ms, and T = right wheel − left wheel.

Adapted: 16 rays are the receptors; the two receptors of wheel-speed errors tell the last action,
left and right; error diffusion stands in place of chance; forward speed, which was the fitness, is
constant here, so contacts are. It runs a period for each decision and remembers what is under way:
at 10 Hz the original's 100 ms, at 50 Hz 20 ms. Steps of 1 ms are a refractory period. ε, η and the
threshold are multiples of 2⁻¹², all sums are whole numbers below 2²⁴ in this unit: exact in float32
too. Evolved here by `python -m reflexarc_baselines.evolving spiking-network`.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import ClassVar, NamedTuple

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Span
from reflexarc_baselines.genome_files import shipped
from reflexarc_baselines.history.spiking_kernel import LANES, live
from reflexarc_baselines.steering import LEFT, RIGHT, steer
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.config.checks import require
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.native.threads import shared
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

NEURONS, RAYS, FIBRES = 10, 16, 18
BITS = 1 + NEURONS + FIBRES
"""Of each neuron."""
UNIT = 1 << 12
"""Of potentials: multiples of 1/UNIT."""
MEMBRANE_MS, SYNAPSE_MS, DELAY_MS, THRESHOLD = 4.0, 10.0, 2.0, 0.1
COUNTED_MS = 20
"""Whose spikes are a wheel's speed."""
REACH_MS = 38
"""Later than this after a spike, ε and η are nearer to 0 than to a unit."""
MEMORY = NEURONS * REACH_MS + FIBRES + 1

_FULL = 2 * FULL_SCALE
"""Charge at which a receptor fires: its probability is in halves of the retina's unit."""
_ROW = re.compile(rf"[+-] [01]{{{NEURONS}}} [01]{{{FIBRES}}}")


@dataclass(frozen=True)
class Connections:
    """A genome of the network."""

    rows: tuple[str, ...]
    """A neuron each: the sign of its effect on others, the neurons and the receptors that it
    takes connections from, such as "+ 0100000001 000000000000000110"."""

    def __post_init__(self) -> None:
        require(len(self.rows) == NEURONS, "rows", f"{NEURONS}, one a neuron", len(self.rows))
        for row in self.rows:
            fits = _ROW.fullmatch(row) is not None
            require(fits, "rows", f"a sign, {NEURONS} and {FIBRES} bits", repr(row), UsageError)


class Thoughts(NamedTuple):
    """What networks carry from one decision to the next, in whole numbers."""

    under_way: Floats
    """Potentials in the next milliseconds, in units: (n, reach, neurons)."""
    charges: Floats
    """Of the receptors: (n, fibres)."""
    last: Floats
    """1 left, −1 right, 0 neither: (n,)."""


def wires(genomes: Sequence[Connections]) -> Floats:
    """Weights from each source to each neuron: (genomes, sources, `LANES`), −1, 0 or 1."""
    made = np.zeros((len(genomes), NEURONS + FIBRES, LANES), np.float32)
    for of_genome, genome in zip(made, genomes, strict=True):
        for i, row in enumerate(genome.rows):
            of_genome[:, i] = list(map(int, "".join(row.split()[1:])))
        for i, row in enumerate(genome.rows):
            of_genome[i] *= 1 if row[0] == "+" else -1
    return made


@lru_cache(maxsize=1)
def kernels() -> Floats:
    """ε and η, 1, 2, … ms after a spike, in units: (2, reach)."""
    s = np.arange(1, REACH_MS + 1)
    since = np.maximum(s - DELAY_MS, 0.0)
    rises = np.exp(-since / MEMBRANE_MS) * (1.0 - np.exp(-since / SYNAPSE_MS))
    both: Floats = np.rint(UNIT * np.stack([rises, -np.exp(-s / MEMBRANE_MS)])).astype(np.float32)
    return both


def wish(
    of_genomes: Floats, retinas: RetinaBatch, memories: Memories, period_s: float
) -> tuple[Floats, Memories]:
    """T of each agent, in spikes, and what it remembers but for its new action.

    Args:
        of_genomes: `wires`; the agents are divided evenly among the genomes, in order.
        retinas: uint8 (n, frames, eyes, rays, channels), of the newest frame the first eye counts.
        memories: (n, `MEMORY`).
        period_s: how long the networks run.
    """
    prepare()
    before = _thoughts(memories)
    gains, spikes = _gains(retinas, before.last), np.empty((len(retinas), NEURONS), np.float32)
    times = (round(1000.0 * period_s), COUNTED_MS)
    thresholds = (np.float32(round(UNIT * THRESHOLD)), np.float32(_FULL))

    def run(first: int, end: int) -> None:
        scratch = np.empty((2 + times[0] + REACH_MS, LANES), np.float32)
        networks = (of_genomes, gains, before.charges, before.under_way, spikes, kernels())
        live(*networks, thresholds, times, scratch, first, end)

    shared(run, len(retinas))
    left, right = spikes[:, 6] - spikes[:, 7], spikes[:, 8] - spikes[:, 9]
    turn: Floats = right - left
    return turn, _memories(before)


def remembering(memories: Memories, actions: Actions) -> Memories:
    """Memories with the action that was chosen."""
    following = memories.copy()
    following[:, -1] = np.where(actions == LEFT, 1.0, np.where(actions == RIGHT, -1.0, 0.0))
    return following


def contract_of_network() -> PolicyContract:
    """The reference field's eye and motions, and what a network has under way."""
    return replace(reference_contract(), state=StateSpec(size=MEMORY))


@dataclass(frozen=True)
class SpikingNetwork:
    """Ten spiking neurons, wired by evolution."""

    ORIGIN: ClassVar[Origin] = Origin(
        "D. Floreano, C. Mattiussi, Evolution of spiking neural controllers for autonomous "
        "vision-based robots, 2001",
        Fidelity.ADAPTED,
        remarks="Sixteen rays in place of 64 pixels, sidesteps in place of wheels; evolved anew, "
        "for contacts per metre.",
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {}

    connections: Connections = field(
        default_factory=partial(shipped, "spiking-network", Connections)
    )
    period_s: float = 0.1
    """Time between two decisions: so long the network runs for each."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return contract_of_network()

    @cached_property
    def _wires(self) -> Floats:
        return wires([self.connections])

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        turn, following = wish(self._wires, retinas, memories, self.period_s)
        q_values, actions = steer(turn)
        return q_values, actions, remembering(following, actions)


def _gains(retinas: RetinaBatch, last: Floats) -> Floats:
    """What receptors gain a millisecond, of `_FULL`: (n, fibres); the ends see themselves twice."""
    grey = np.rint(retinas[:, -1, 0].mean(axis=-1, dtype=np.float32))
    seen = np.pad(grey, ((0, 0), (1, 1)), mode="edge")
    edges = np.abs(2 * seen[:, 1:-1] - seen[:, :-2] - seen[:, 2:])
    moved = np.stack([last == 1, last == -1], axis=1) * _FULL
    return np.ascontiguousarray(np.concatenate([edges, moved], axis=1), np.float32)


def _thoughts(memories: Memories) -> Thoughts:
    whole = np.rint(memories).astype(np.float32)
    under_way, charges = whole[:, : NEURONS * REACH_MS], whole[:, NEURONS * REACH_MS : -1]
    shaped = under_way.reshape(-1, REACH_MS, NEURONS)
    return Thoughts(shaped.copy(), charges.copy(), memories[:, -1].copy())


def _memories(thoughts: Thoughts) -> Memories:
    flat = thoughts.under_way.reshape(len(thoughts.last), -1)
    parts = (flat, thoughts.charges, thoughts.last[:, np.newaxis])
    return np.concatenate(parts, axis=1)
