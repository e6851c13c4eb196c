"""The spiking network of many agents, compiled: millisecond by millisecond in whole numbers.

They are whole float32 numbers below 2²⁴, so nothing is ever rounded, in whatever order it is added.
Potentials are in units of 2⁻¹² (`spiking_network.py` says what they mean). All of a spike's effect
to come is added to the potentials that are under way as soon as the spike occurs, so the network
needs no list of past spikes. Rows of neurons are `LANES` long, a vector of a processor; what is
behind the last neuron stays 0.
"""

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_free, compiled_part

LANES = 16


@compiled_free
def live(
    wires: Floats,
    fibres: Floats,
    charges: Floats,
    under_way: Floats,
    spikes: Floats,
    kernels: Floats,
    thresholds: tuple[np.float32, np.float32],
    times: tuple[int, int],
    scratch: Floats,
    first: int,
    end: int,
) -> None:
    """Run the networks of some agents for one decision; all arrays but `scratch` are of all agents.

    Args:
        wires: −1, 0 or 1 from each source (neurons, then fibres) to each neuron of each genome:
            (genomes, sources, `LANES`). The agents are divided evenly among the genomes, in order.
        fibres: what each receptor's fibre gains a millisecond: (agents, fibres).
        charges: what each fibre has gained since its last spike; goes on: (agents, fibres).
        under_way: potential of each neuron in the next milliseconds, as far as it is known already;
            goes on: (agents, reach, neurons).
        spikes: filled: of each neuron, in the last `times[1]` milliseconds: (agents, neurons).
        kernels: ε and η, 1, 2, … ms after a spike: (2, reach).
        thresholds: above which a neuron fires, and the charge at which a fibre does, which is then
            taken off.
        times: milliseconds of the decision, and how many of them count for `spikes`.
        scratch: room for a thread: (2 + milliseconds + reach, `LANES`).
        first: first agent.
        end: agent behind the last.
    """
    inflow, fired, potentials = scratch[0], scratch[1], scratch[2:]
    each, reach = len(fibres) // len(wires), kernels.shape[1]
    for i in range(first, end):
        _begin(potentials, under_way[i], spikes[i])
        of_genome = wires[i // each]
        for t in range(times[0]):
            inflow[:] = 0
            fired[:] = 0
            some = _fire_fibres(of_genome, fibres[i], charges[i], thresholds[1], inflow)
            counts = np.float32(1 if t >= times[0] - times[1] else 0)
            some += _fire_neurons(
                of_genome, potentials[t], thresholds[0], fired, inflow, spikes[i], counts
            )
            if some > 0:
                _spread(potentials[t + 1 : t + 1 + reach], kernels, inflow, fired)
        _end(potentials[times[0] :], under_way[i])


@compiled_part
def _begin(potentials: Floats, under_way: Floats, spikes: Floats) -> None:
    potentials[:] = 0
    spikes[:] = 0
    for t in range(under_way.shape[0]):
        for n in range(under_way.shape[1]):
            potentials[t, n] = under_way[t, n]


@compiled_part
def _end(potentials: Floats, under_way: Floats) -> None:
    for t in range(under_way.shape[0]):
        for n in range(under_way.shape[1]):
            under_way[t, n] = potentials[t, n]


@compiled_part
def _fire_fibres(
    wires: Floats, gains: Floats, charges: Floats, full: np.float32, inflow: Floats
) -> int:
    """Error diffusion in place of chance: a fibre fires as often as its gain says, evenly."""
    fires = 0
    first = len(wires) - len(gains)
    for j in range(len(gains)):
        charges[j] += gains[j]
        if charges[j] >= full:
            charges[j] -= full
            fires += 1
            _add(inflow, wires[first + j])
    return fires


@compiled_part
def _fire_neurons(
    wires: Floats,
    potentials: Floats,
    threshold: np.float32,
    fired: Floats,
    inflow: Floats,
    spikes: Floats,
    counts: np.float32,
) -> int:
    """Neurons above threshold fire."""
    fires = 0
    for j in range(len(spikes)):
        if potentials[j] > threshold:
            spikes[j] += counts
            fired[j] = 1
            fires += 1
            _add(inflow, wires[j])
    return fires


@compiled_disjoint
def _add(inflow: Floats, row: Floats) -> None:
    for n in range(len(inflow)):
        inflow[n] += row[n]


@compiled_part
def _spread(coming: Floats, kernels: Floats, inflow: Floats, fired: Floats) -> None:
    """What the spikes of this millisecond will do to each neuron, its own resets among them."""
    for s in range(kernels.shape[1]):
        _arrive(coming[s], inflow, kernels[0, s], fired, kernels[1, s])


@compiled_disjoint
def _arrive(
    coming: Floats, inflow: Floats, arriving: np.float32, fired: Floats, resetting: np.float32
) -> None:
    """A loop as long as its arrays becomes vectors; of `LANES` it would be unrolled first."""
    for n in range(len(coming)):
        coming[n] += inflow[n] * arriving + fired[n] * resetting
