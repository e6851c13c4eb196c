"""One decision at a time, over kept arrays, against the batch, which knows nothing of them."""

import threading
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.policy.kept_graph import KeptGraph
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from support.policies import SMALL, exported
from support.remembering import REMEMBERING, UNITS, remembering_policy

ACTIVATIONS = ("Sigmoid", "Relu", "Tanh", "Elu", "Softplus", "Softsign")


def retinas_for(contract: PolicyContract, count: int, seed: int) -> np.ndarray:
    shape = (count, *contract.retina.stack_shape)
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


@given(st.sampled_from(ACTIVATIONS), st.integers(1, 40), st.integers(1, 3), st.integers(0, 2**20))
@settings(deadline=None, max_examples=30)
def test_any_network_gives_one_by_one_the_bits_of_the_plain_operators(
    activation: str, rays: int, frames: int, seed: int
) -> None:
    contract = PolicyContract(retina=RetinaSpec(rays=rays, frames=frames))
    policy = load_policy(exported(contract, seed, activation), verify=False)
    plain = load_policy(policy.data, verify=False)
    retinas = retinas_for(contract, 20, seed)
    for row in retinas:
        mine = policy.decide(row[np.newaxis])
        its = one_by_the_plain_operators(plain, row[np.newaxis])
        assert [x.tobytes() for x in mine] == [x.tobytes() for x in its]


def one_by_the_plain_operators(policy: LoadedPolicy, stack: np.ndarray) -> tuple[np.ndarray, ...]:
    """As a batch of two, of which one is the other: no array is kept for two."""
    q_values, actions = policy.decide(np.concatenate([stack, stack]))
    return q_values[:1], actions[:1]


def test_what_it_gave_stays_what_it_was() -> None:
    policy = load_policy(remembering_policy())
    retinas = retinas_for(REMEMBERING, 3, 0)
    memory = np.full((1, UNITS), 0.25, np.float32)
    first = policy.decide(retinas[:1], memory)
    before = [array.copy() for array in first]
    seen = retinas[:1].copy()
    policy.decide(retinas[1:2], first[2])
    for array, was in zip(first, before, strict=True):
        np.testing.assert_array_equal(array, was)
    np.testing.assert_array_equal(retinas[:1], seen)


def test_two_threads_at_once_get_answers_of_their_own() -> None:
    policy = load_policy(exported(SMALL))
    retinas = retinas_for(SMALL, 400, 1)
    expected = policy.decide(retinas)[0]
    wrong: list[int] = []

    def ask(rows: range) -> None:
        for row in rows:
            q_values, _ = policy.decide(retinas[row : row + 1])
            if q_values.tobytes() != expected[row : row + 1].tobytes():
                wrong.append(row)

    threads = [threading.Thread(target=ask, args=(range(400)[:: (-1) ** n],)) for n in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_while_another_thread_is_at_it_the_plain_operators_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    policy = load_policy(exported(SMALL))
    retinas = retinas_for(SMALL, 2, 2)
    expected = policy.decide(retinas)[0]
    policy.decide(retinas[:1])
    nested: list[np.ndarray] = []
    run: Callable[..., object] = KeptGraph.run

    def interrupted(self: KeptGraph, *given: object) -> object:
        nested.append(policy.decide(retinas[1:])[0])  # as another thread would, in the middle
        return run(self, *given)

    monkeypatch.setattr(KeptGraph, "run", interrupted)
    q_values, _ = policy.decide(retinas[:1])
    assert q_values.tobytes() == expected[:1].tobytes()
    assert [n.tobytes() for n in nested] == [expected[1:].tobytes()]


@pytest.mark.parametrize("count", [1, 2])
def test_another_shape_than_the_first_is_computed_all_the_same(count: int) -> None:
    policy = load_policy(exported(SMALL), verify=False)
    retinas = retinas_for(SMALL, 4, 3)
    policy.decide(retinas[:1])
    expected = policy.decide(retinas)[0]
    assert policy.decide(retinas[:count])[0].tobytes() == expected[:count].tobytes()
