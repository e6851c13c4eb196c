"""What float32 gets wrong with users' networks is never more than the bound says, and known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_runtime.policy.onnxruntime_backend import OnnxruntimeGraph
from reflexarc_trainer.policy.export import as_exported, build_model
from reflexarc_trainer.policy.probes import (
    Probes,
    probe_memories,
    probe_retinas,
    reached_memories,
)
from reflexarc_trainer.policy.rounding.rounding_bound import (
    LARGEST_TOLERANCE,
    rounding_bound,
)
from support.architectures import ARCHITECTURES, contract_of, network


def bound_and_measured(name: str, gain: float, seed: int) -> tuple[float, float]:
    """The bound, and the largest difference for inputs that it did not see."""
    contract = contract_of(name)
    model = build_model(as_exported(network(name, gain, seed)), contract)
    reference = NumpyGraph(model)
    retinas, memories = probe_retinas(contract, None), None
    fresh = np.random.default_rng(98).integers(0, 256, (1000, 1, 1, 16, 1), np.uint8)
    if contract.state.size:
        reached = reached_memories(reference, contract)
        memories = probe_memories(contract, reached, len(retinas))
    bound = rounding_bound(model, Probes(retinas, memories))
    given = None if memories is None else memories[: len(fresh)][::-1].copy()
    exact = reference.run(fresh, given)
    rounded = OnnxruntimeGraph(model.SerializeToString()).run(fresh, given)
    apart = max(
        float(np.max(np.abs(b.astype(np.float64) - a) / np.maximum(1.0, np.abs(a))))
        for a, b in zip(exact[::2], rounded[::2], strict=True)
        if a is not None and b is not None
    )
    return bound, apart


@given(
    name=st.sampled_from(sorted(ARCHITECTURES)),
    gain=st.floats(0.1, 100.0),
    seed=st.integers(0, 10_000),
)
@settings(deadline=None, max_examples=40)
def test_float32_never_differs_by_more(name: str, gain: float, seed: int) -> None:
    bound, apart = bound_and_measured(name, gain, seed)
    assert apart <= bound


@pytest.mark.parametrize("name", ARCHITECTURES)
def test_every_kind_has_a_bound_that_says_something(name: str) -> None:
    bound, apart = bound_and_measured(name, 1.0, 5)
    assert apart <= bound < LARGEST_TOLERANCE / 5
