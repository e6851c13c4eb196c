"""A policy with a memory: what it remembers goes out with a decision, and back in with the next."""

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.contract.golden import GoldenSequence
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import within_tolerance
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_policy
from support.networks import with_weights
from support.remembering import REMEMBERING, STEPS, UNITS, remembering_policy

RETINAS = np.random.default_rng(4).integers(
    0, 256, (300, *REMEMBERING.retina.stack_shape), dtype=np.uint8
)
MEMORIES = np.random.default_rng(5).uniform(-1.0, 1.0, (300, UNITS)).astype(np.float32)
BACKENDS = ["numpy", "onnxruntime"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_without_a_memory_given_it_decides_from_its_start_value(backend: str) -> None:
    policy = load_policy(remembering_policy(), backend)
    start = np.tile(np.array(REMEMBERING.state.start, np.float32), (300, 1))
    assert np.array_equal(policy.decide(RETINAS)[0], policy.decide(RETINAS, start)[0])
    assert not np.array_equal(policy.decide(RETINAS)[0], policy.decide(RETINAS, MEMORIES)[0])


def test_one_at_a_time_gives_the_bits_of_the_batch() -> None:
    policy = load_policy(remembering_policy())
    batch = policy.decide(RETINAS, MEMORIES)
    rows = zip(RETINAS[:, np.newaxis], MEMORIES[:, np.newaxis], strict=True)
    singles = [policy.decide(retina, memory) for retina, memory in rows]
    for whole, parts in zip(batch, zip(*singles, strict=True), strict=True):
        assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_both_backends_agree_in_values_and_memories() -> None:
    data = remembering_policy()
    mine = load_policy(data, "numpy").decide(RETINAS, MEMORIES)
    its = load_policy(data, "onnxruntime").decide(RETINAS, MEMORIES)
    assert within_tolerance(its[0], mine[0], REMEMBERING.q_tolerance)
    assert within_tolerance(its[2], mine[2], REMEMBERING.q_tolerance)


def negate(place: tuple[int, ...]) -> Callable[[npt.NDArray[np.float32]], None]:
    def change(weights: npt.NDArray[np.float32]) -> None:
        weights[place] = -weights[place]

    return change


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("name", "place"), [("w", (0, 3, 1)), ("r", (0, 7, 2)), ("b", (0, 4)), ("head", (1, 1))]
)
def test_a_flipped_weight_is_refused(name: str, place: tuple[int, ...], backend: str) -> None:
    with pytest.raises(PolicyError, match=r"golden (vectors|sequences) are not reproduced"):
        load_policy(with_weights(remembering_policy(), name, negate(place)), backend)


def changed(change: Callable[[GoldenSequence], GoldenSequence]) -> bytes:
    policy = load_policy(remembering_policy())
    golden = policy.contract.golden
    golden = dataclasses.replace(golden, sequences=(change(golden.sequences[0]),))
    return with_contract(policy.data, dataclasses.replace(policy.contract, golden=golden))


def other_end(golden: GoldenSequence) -> GoldenSequence:
    return dataclasses.replace(golden, end=(golden.end[0] + 0.01, *golden.end[1:]))


def other_order(golden: GoldenSequence) -> GoldenSequence:
    retinas = (golden.retinas[1], golden.retinas[0], *golden.retinas[2:])
    return dataclasses.replace(golden, retinas=retinas)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("change", [other_end, other_order])
def test_a_sequence_that_goes_another_way_is_refused(
    change: Callable[[GoldenSequence], GoldenSequence], backend: str
) -> None:
    with pytest.raises(PolicyError, match="golden sequences are not reproduced"):
        load_policy(changed(change), backend)


def test_a_sequence_may_differ_by_its_tolerance_times_its_ticks_on_onnxruntime_alone() -> None:
    def nudged(share: float) -> bytes:
        def change(golden: GoldenSequence) -> GoldenSequence:
            end = float(np.float32(golden.end[0] + share * STEPS * REMEMBERING.q_tolerance))
            return dataclasses.replace(golden, end=(end, *golden.end[1:]))

        return changed(change)

    load_policy(nudged(0.9), "onnxruntime")
    for data, backend in ((nudged(1.1), "onnxruntime"), (nudged(0.9), "numpy")):
        with pytest.raises(PolicyError, match="golden sequences"):
            load_policy(data, backend)


def test_a_memory_without_golden_sequences_is_refused() -> None:
    policy = load_policy(remembering_policy())
    golden = dataclasses.replace(policy.contract.golden, sequences=())
    data = with_contract(policy.data, dataclasses.replace(policy.contract, golden=golden))
    with pytest.raises(PolicyError, match="no golden sequences"):
        load_policy(data)
