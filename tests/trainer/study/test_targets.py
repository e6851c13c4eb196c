"""Targets: bounds on the mean and on every seed."""

import pytest

from reflexarc_trainer.study.targets import Target


@pytest.mark.parametrize(
    ("target", "figures", "said"),
    [
        (Target("a", each_at_most=3.0), [1.0, 2.0, 3.0], []),
        (Target("a", each_at_most=2.5), [1.0, 2.0, 3.0], ["a seed has 3, expected ≤ 2.5"]),
        (Target("a", mean_at_most=1.5), [1.0, 2.0, 3.0], ["mean 2, expected ≤ 1.5"]),
        (Target("a", mean_at_least=2.0, each_at_least=1.5), [1.0, 2.0, 3.0], ["a seed has 1, "]),
        (Target("a", mean_at_most=9.0), [1.0, 2.0], ["1 of 3 seeds have no figure"]),
    ],
)
def test_targets_bound_the_mean_and_every_seed(
    target: Target, figures: list[float], said: list[str]
) -> None:
    missed = target.missed(figures, 3)
    assert len(missed) == len(said)
    assert all(words in got for words, got in zip(said, missed, strict=True))
