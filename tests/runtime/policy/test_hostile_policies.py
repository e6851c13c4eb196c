"""Policies that were made to harm are refused in one line, or do no harm."""

import numpy as np
import pytest

from reflexarc_runtime.errors import PolicyError, ReflexarcError
from reflexarc_runtime.policy.policy import load_policy
from support.hostile_policies import POLICIES
from support.policies import SMALL

HARMLESS = {
    "a shape by what is seen",
    "added to itself for ever",
    "fifty thousand golden vectors",
}
"""What the NumPy backend loads: the first is refused later, and the others end in time."""
SLOW_TO_MAKE = {
    "100 MiB of metadata",
    "a contract of 60 MiB",
    "a contract of ten million lists",
    "a contract of ten million numbers",
    "a hundred thousand actions",
    "a hundred thousand nodes",
    "fifty thousand golden vectors",
    "graphs within graphs",
    "many sums of many numbers",
    "ten million empty nodes",
    "ten million empty weights",
    "whole numbers that unfold",
}


def refusal_of(name: str) -> str:
    """What the NumPy backend says of it."""
    with pytest.raises(ReflexarcError) as refusal:
        load_policy(POLICIES[name]())
    return str(refusal.value)


@pytest.mark.parametrize("name", sorted(POLICIES.keys() - HARMLESS - SLOW_TO_MAKE))
def test_a_hostile_policy_is_refused_in_one_short_line(name: str) -> None:
    said = refusal_of(name)
    assert said.isprintable()
    assert len(said) < 400


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(SLOW_TO_MAKE - HARMLESS))
def test_a_large_one_is_too(name: str) -> None:
    said = refusal_of(name)
    assert said.isprintable()
    assert len(said) < 400


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("an outer product", "3052 MiB, more than 64 MiB"),
        ("an expansion", "more than 64 MiB"),
        ("many matrix products", "more than 1073741824 multiplications"),
        ("two million steps of a GRU", "GRU"),
        ("weights in /dev/zero", "its weights lie in /dev/zero; embed them"),
        ("weights in a folder above", "its weights lie in ../../secret; embed them"),
        ("weights of 10¹² without any", "at most 16777216 weights, got 1e"),
        ("a retina of floats", "a retina of type UINT8, got FLOAT"),
        ("a contract of a hundred thousand depths", "expected JSON"),
    ],
)
def test_the_reason_is_the_true_one(name: str, reason: str) -> None:
    assert reason in refusal_of(name)


def test_what_only_a_bright_retina_would_take_is_refused_when_it_comes() -> None:
    policy = load_policy(POLICIES["a shape by what is seen"]())
    dark = np.zeros((2, *SMALL.retina.stack_shape), np.uint8)
    assert policy.decide(dark)[0].shape == (2, 3)
    with pytest.raises(PolicyError, match="MiB, more than"):
        policy.decide(dark + 255)
    assert policy.decide(dark)[0].shape == (2, 3)
