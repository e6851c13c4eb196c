"""The network against a table by hand, and against the formula, spike by spike."""

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.evolving.race import race
from reflexarc_baselines.evolving.spiking_species import SpikingCrowd, SpikingSpecies
from reflexarc_baselines.history.spiking_kernel import LANES, live
from reflexarc_baselines.history.spiking_network import (
    FIBRES,
    MEMORY,
    NEURONS,
    REACH_MS,
    UNIT,
    Connections,
    SpikingNetwork,
    kernels,
    wires,
    wish,
)
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

WITHOUT_RESET = [0.0, 0.0, 0.0741, 0.1100, 0.1224, 0.1213, 0.1127, 0.1007]
"""Potential 1 to 8 ms after a spike that comes over a weight of 1."""
FIBRE, INHIBITOR = 0, 9


class OneNeuron:
    """Neuron 0 is excited by fibre 0, which fires at 0 ms, and inhibited by neuron 9."""

    def __init__(self, inhibited: bool = False) -> None:
        self._wires = np.zeros((1, NEURONS + FIBRES, LANES), np.float32)
        self._wires[0, NEURONS + FIBRE, 0], self._wires[0, INHIBITOR, 0] = 1.0, -1.0
        self._charges = np.zeros((1, FIBRES), np.float32)
        self._charges[0, FIBRE] = 510.0
        self.under_way = np.zeros((1, REACH_MS, NEURONS), np.float32)
        if inhibited:
            self.under_way[0, 0, INHIBITOR] = UNIT

    def run(self, duration_ms: int) -> int:
        """How often neuron 0 fires."""
        spikes, still = np.zeros((1, NEURONS), np.float32), np.zeros((1, FIBRES), np.float32)
        networks = (self._wires, still, self._charges, self.under_way, spikes, kernels())
        thresholds = (np.float32(410.0), np.float32(510.0))
        scratch = np.empty((2 + duration_ms + REACH_MS, LANES), np.float32)
        live(*networks, thresholds, (duration_ms, duration_ms), scratch, 0, 1)
        return int(spikes[0, 0])

    @property
    def potentials(self) -> Floats:
        """Of the coming milliseconds, as far as they are known."""
        coming: Floats = self.under_way[0, :, 0] / UNIT
        return coming


def test_a_spike_raises_the_potential_as_in_the_table() -> None:
    neuron = OneNeuron()
    neuron.run(1)
    assert neuron.potentials[:8] == pytest.approx(WITHOUT_RESET, abs=0.00005 + 0.5 / UNIT)


def test_it_fires_at_four_milliseconds_and_then_resets() -> None:
    neuron = OneNeuron()
    assert [neuron.run(4), neuron.run(1)] == [0, 1]
    reset = np.add(WITHOUT_RESET[4:7], [-0.7788, -0.6065, -0.4724])
    assert neuron.potentials[:3] == pytest.approx(reset, abs=0.0001 + 1.0 / UNIT)


def test_an_equal_spike_that_inhibits_takes_all_of_it() -> None:
    neuron = OneNeuron(inhibited=True)
    assert neuron.run(1) == 0
    assert (neuron.potentials == 0.0).all()


def plain_spikes(genome: Connections, grey: list[int], duration_ms: int) -> npt.NDArray[np.bool_]:
    """The formula itself: sums over all past spikes, (ms, neurons)."""
    lists = [row.split() for row in genome.rows]
    seen = [grey[0], *grey, grey[-1]]
    gains = [abs(2 * seen[i] - seen[i - 1] - seen[i + 1]) for i in range(1, 17)] + [0, 0]
    fibres = [
        [t for t in range(duration_ms) if (t + 1) * gain // 510 > t * gain // 510] for gain in gains
    ]
    epsilon, eta = ([0.0, *kernel, *[0.0] * duration_ms] for kernel in kernels().tolist())
    neurons: list[list[int]] = [[] for _ in range(NEURONS)]
    fired = np.zeros((duration_ms, NEURONS), np.bool_)
    for t in range(duration_ms):
        for i, (_, from_neurons, from_fibres) in enumerate(lists):
            u = sum(eta[t - s] for s in neurons[i] if s < t)
            for j in range(NEURONS):
                sign = 1 if lists[j][0] == "+" else -1
                wired_to = int(from_neurons[j])
                u += sign * wired_to * sum(epsilon[t - s] for s in neurons[j] if s < t)
            u += sum(
                int(from_fibres[j]) * epsilon[t - s]
                for j in range(FIBRES)
                for s in fibres[j]
                if s < t
            )
            fired[t, i] = u > 410
        for i in range(NEURONS):
            neurons[i] += [t] if fired[t, i] else []
    return fired


@pytest.mark.parametrize("seed", range(4))
def test_it_computes_the_formula(seed: int) -> None:
    generator = np.random.default_rng(seed)
    genes = SpikingSpecies().first(1, generator)
    genome = SpikingSpecies().grown(genes[0])
    grey = generator.integers(0, 120, 16)
    fired = plain_spikes(genome, grey.tolist(), 100)[80:].sum(axis=0).astype(int)
    assert fired.sum() > 20
    turn, _ = wish(wires([genome]), retinas_of(grey), np.zeros((1, MEMORY), np.float32), 0.1)
    assert turn.tolist() == [fired[8] - fired[9] - fired[6] + fired[7]]


def retinas_of(grey: npt.NDArray[np.int64]) -> RetinaBatch:
    return grey.astype(np.uint8).reshape(1, 1, 1, 16, 1)


def test_five_short_decisions_go_on_where_one_long_one_is() -> None:
    generator = np.random.default_rng(7)
    of_genome = wires([SpikingSpecies().grown(SpikingSpecies().first(1, generator)[0])])
    retinas = retinas_of(generator.integers(0, 256, 16))
    start = np.zeros((1, MEMORY), np.float32)
    long, long_memory = wish(of_genome, retinas, start, 0.1)
    memory = start
    for _ in range(5):
        short, memory = wish(of_genome, retinas, memory, 0.02)
    assert short == long
    assert (memory == long_memory).all()
    assert (start == 0.0).all()
    assert np.abs(memory).max() > UNIT


def test_the_last_action_reaches_a_receptor_of_its_own() -> None:
    """Only neuron 6, left and forward, listens, and only to the receptor of "left"."""
    silent, deaf = "0" * NEURONS, "0" * FIBRES
    rows = [f"+ {silent} {deaf}"] * NEURONS
    rows[6] = f"+ {silent} {'0' * 16}10"
    network, dark = SpikingNetwork(Connections(tuple(rows))), retinas_of(np.zeros(16, np.int64))
    memories = np.zeros((3, MEMORY), np.float32)
    memories[:, -1] = 1.0, -1.0, 0.0
    q_values, actions, following = network.decide(np.repeat(dark, 3, axis=0), memories)
    assert q_values[0, 1] < 0.0
    assert q_values[1:, 1].tolist() == [0.0, 0.0]
    assert actions.tolist() == [2, 0, 0]
    assert following[:, -1].tolist() == [-1.0, 0.0, 0.0]


def test_rows_that_are_no_genome_are_refused() -> None:
    with pytest.raises(UsageError, match="10, one a neuron"):
        Connections(("+ 0000000000 000000000000000000",))
    with pytest.raises(UsageError, match="a sign"):
        Connections(("+ 000000000 0000000000000000000",) * NEURONS)


SEEDS = validation_seeds(64)


class Shuffled:
    """The network with its receptors at each other's places."""

    def __init__(self, network: SpikingNetwork) -> None:
        self._network, self._order = network, np.random.default_rng(0).permutation(16)

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        return self._network.decide(np.ascontiguousarray(retinas[..., self._order, :]), memories)


def rate(policy: SpikingNetwork | Shuffled) -> float:
    contract = SpikingNetwork().contract
    score = measure(policy, contract, agents=128, steps=200, seeds=validation_seeds(128))
    return score.contacts_per_100m


@pytest.mark.long
def test_it_beats_random_motion_and_itself_with_shuffled_receptors() -> None:
    contract = reference_contract()
    chance = measure(RandomPolicy(0), contract, agents=128, steps=200, seeds=SEEDS)
    evolved = rate(SpikingNetwork())
    assert evolved < 0.75 * chance.contacts_per_100m
    assert evolved < 0.85 * rate(Shuffled(SpikingNetwork()))


def test_it_beats_every_one_of_its_first_generation() -> None:
    species = SpikingSpecies()
    first = species.crowd(species.first(64, np.random.default_rng(0)))
    evolved = SpikingCrowd(wires([SpikingNetwork().connections]))
    in_worlds = (species.contract, "reference-1")
    costs = race(first, *in_worlds, 64, SEEDS[:16], 100)
    assert race(evolved, *in_worlds, 1, SEEDS[:16], 100)[0] < costs.min()
