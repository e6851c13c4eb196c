"""What every system that sees distances owes to a log: the same bits from the same row."""

import numpy as np
import pytest

from reflexarc_baselines.baseline import Baseline, Remembering, Sees
from reflexarc_baselines.registry import HOMES, baseline_named
from reflexarc_runtime.arrays import Memories, QValues, RetinaBatch
from support.ranges_seen import assorted, unremembered

NAMES = [
    "rob-nav",
    "subsumption-0",
    "subsumption-1",
    "subsumption",
    "motor-schemas-sum",
    "motor-schemas-largest",
    "layered-wander",
    "layered-perimeter",
]
AGENTS = 64


def decided(
    policy: Baseline | Remembering, retinas: RetinaBatch, memories: Memories
) -> tuple[QValues, Memories]:
    """Q-values, and the memories after them."""
    if not policy.contract.state.size:
        return policy.decide(retinas)[0], memories
    q_values, _, following = policy.decide(retinas, memories)
    assert following.dtype == np.float32
    assert following.shape == memories.shape
    return q_values, following


def bits(policy: Baseline | Remembering, retinas: RetinaBatch, memories: Memories) -> bytes:
    return b"".join(array.tobytes() for array in decided(policy, retinas, memories))


@pytest.mark.parametrize("name", NAMES)
def test_an_agent_decides_to_the_same_bits_alone_and_among_others(name: str) -> None:
    policy = baseline_named(name)
    crowd = unremembered(policy.contract, AGENTS)
    alone = [unremembered(policy.contract) for _ in range(AGENTS)]
    for step in range(4):
        retinas = np.roll(assorted(AGENTS), step, axis=3)
        together, crowd = decided(policy, retinas, crowd)
        pairs = [decided(policy, retinas[[i]], alone[i]) for i in range(AGENTS)]
        alone = [memory for _, memory in pairs]
        assert np.concatenate([q_values for q_values, _ in pairs]).tobytes() == together.tobytes()
        assert np.concatenate(alone).tobytes() == crowd.tobytes()


@pytest.mark.parametrize("name", NAMES)
def test_the_same_arguments_give_the_same_bits_and_are_left_alone(name: str) -> None:
    policy, retinas = baseline_named(name), assorted(AGENTS)
    memories = unremembered(policy.contract, AGENTS)
    before = (retinas.tobytes(), memories.tobytes())
    first = bits(policy, retinas, memories)
    assert bits(policy, retinas, memories) == first
    assert bits(baseline_named(name), retinas, memories) == first
    assert (retinas.tobytes(), memories.tobytes()) == before


@pytest.mark.parametrize("name", NAMES)
def test_it_says_that_it_sees_distances(name: str) -> None:
    assert baseline_named(name).ORIGIN.sees is Sees.RANGES
    assert HOMES[name].startswith("history.")
