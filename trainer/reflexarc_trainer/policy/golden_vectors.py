"""Golden vectors and sequences: what the NumPy reference computes for some retinas."""

import numpy as np

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.golden import GoldenSequence, GoldenVectors
from reflexarc_runtime.policy.golden_check import Graph, start_of
from reflexarc_trainer.policy.probes import golden_sequences

GOLDEN_VECTORS = 16


def golden_of(graph: Graph, contract: PolicyContract, retinas: RetinaBatch) -> GoldenVectors:
    """The golden vectors of a policy, from its start value, and its sequences if it remembers.

    Args:
        graph: the policy on the NumPy reference.
        contract: its contract.
        retinas: of which evenly picked ones are taken: uint8 (n, frames, eyes, rays, channels).
    """
    chosen = retinas[np.linspace(0, len(retinas) - 1, GOLDEN_VECTORS).astype(int)]
    q_values, actions, _ = graph.run(chosen, start_of(contract, len(chosen)))
    return GoldenVectors(
        retinas=_rows(chosen),
        q_values=tuple(tuple(map(float, row)) for row in q_values),
        actions=tuple(map(int, actions)),
        sequences=tuple(_sequence(graph, contract, each) for each in golden_sequences(contract)),
    )


def _sequence(graph: Graph, contract: PolicyContract, retinas: RetinaBatch) -> GoldenSequence:
    memories, values, winners = start_of(contract, 1), [], []
    for retina in retinas:
        q_values, actions, memories = graph.run(retina[np.newaxis], memories)
        values.append(tuple(map(float, q_values[0])))
        winners.append(int(actions[0]))
    assert memories is not None
    return GoldenSequence(
        retinas=_rows(retinas),
        q_values=tuple(values),
        actions=tuple(winners),
        end=tuple(map(float, memories[0])),
    )


def _rows(retinas: RetinaBatch) -> tuple[tuple[int, ...], ...]:
    return tuple(tuple(map(int, row)) for row in retinas.reshape(len(retinas), -1))
