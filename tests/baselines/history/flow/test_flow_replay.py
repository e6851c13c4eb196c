"""What every system that sees by flow owes to a log: the same bits from the same row."""

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_baselines.baseline import Baseline, Remembering, Sees
from reflexarc_baselines.registry import HOMES, baseline_named
from reflexarc_runtime.arrays import Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.eye import Shading
from support.ranges_seen import unremembered

NAMES = sorted(name for name in HOMES if name.startswith("flow-"))
AGENTS = 64


def assorted(step: int) -> RetinaBatch:
    generator = np.random.default_rng(step)
    return generator.integers(0, 256, (AGENTS, 2, 1, 16, 1), dtype=np.uint8)


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


@pytest.mark.parametrize("name", NAMES)
def test_an_agent_decides_to_the_same_bits_alone_and_among_others(name: str) -> None:
    policy = baseline_named(name)
    crowd = unremembered(policy.contract, AGENTS)
    alone = [unremembered(policy.contract) for _ in range(AGENTS)]
    for step in range(6):
        retinas = assorted(step)
        before: list[npt.NDArray[np.generic]] = [retinas.copy(), crowd.copy()]
        together, following = decided(policy, retinas, crowd)
        assert (before[0] == retinas).all()
        assert (before[1] == crowd).all()
        crowd = following
        pairs = [decided(policy, retinas[[i]], alone[i]) for i in range(AGENTS)]
        alone = [memory for _, memory in pairs]
        assert together.dtype == np.float32
        assert np.isfinite(together).all()
        assert np.concatenate([q_values for q_values, _ in pairs]).tobytes() == together.tobytes()
        assert np.concatenate(alone).tobytes() == crowd.tobytes()


@pytest.mark.parametrize("name", NAMES)
def test_it_sees_two_frames_of_colour(name: str) -> None:
    policy = baseline_named(name)
    eye = policy.contract.retina
    assert policy.ORIGIN.sees is Sees.RETINA
    assert (eye.frames, eye.shading, eye.samples) == (2, Shading.COLOUR, 16)
    assert policy.ORIGIN.home_world.startswith("bees")


@pytest.mark.parametrize("name", NAMES)
def test_it_counts_in_the_periods_that_its_contract_runs_at(name: str) -> None:
    policy = baseline_named(name)
    assert getattr(policy, "period_s") * policy.contract.rate_hz == 1.0  # noqa: B009  # no part of the protocol
