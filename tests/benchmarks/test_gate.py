"""The gate's own error rates are found as they are: on contacts whose loss is known."""

from collections.abc import Callable
from pathlib import Path

import gate
import gate_drives
import numpy as np
import pytest
from gate_drives import NEAR_ENOUGH, Careless, Driven, share_for

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_sim_bridge.evaluation.driving.paired_drive import LOOKS, Pair
from reflexarc_sim_bridge.evaluation.scoring.regression import Claim, Look, look_at, overall

WORLDS = 1000


class Left:
    """Always the second action, by 1 in Q."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy.decide`."""
        n = len(retinas)
        return np.tile(np.array([0.0, 1.0, 0.0], np.float32), (n, 1)), np.full(n, 1)


def driven(mean: float, ratio: float, seed: int = 0) -> Driven:
    """Contacts after all looks, each with twice as much behind it; the worse `ratio` times."""
    generator = np.random.default_rng(seed)
    means = mean * np.diff([0.0, *2.0 ** np.arange(LOOKS)])[:, np.newaxis]
    drawn = [
        generator.poisson(factor * means, (2, LOOKS, WORLDS)).cumsum(axis=1).astype(float)
        for factor in (1.0, ratio)
    ]
    return Driven(*drawn)


def test_a_careless_policy_looks_away_as_often_as_it_is_told() -> None:
    q_values, actions = Careless(Left(), 0.3, seed=1).decide(np.zeros((20_000, 1), np.uint8))
    away = (q_values == 0.0).all(axis=1)
    assert away.mean() == pytest.approx(0.3, abs=0.015)
    assert (actions == np.where(away, 0, 1)).all()


@pytest.mark.parametrize(
    "loss_of",
    [
        lambda share: 2.0 * share,
        lambda share: 30.0 * share**2,
        lambda share: 60.0 * share**3,
        lambda share: 2000.0 * share**6 - 0.1 * share,
        lambda share: 1.1 * share**0.5,
    ],
)
def test_a_share_is_tried_until_the_copy_loses_what_is_aimed_at(
    loss_of: Callable[[float], float],
) -> None:
    tried: list[float] = []

    def noted(share: float) -> float:
        tried.append(share)
        return loss_of(share)

    assert NEAR_ENOUGH[0] <= loss_of(share_for(noted)) <= NEAR_ENOUGH[1]
    assert len(tried) <= 8


def test_a_copy_that_carelessness_helps_looks_away_always() -> None:
    assert share_for(lambda share: -0.1 * share) == 1.0


def test_what_was_driven_is_kept_and_not_driven_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drives = [driven(1.0, 1.2)]
    monkeypatch.setattr(gate_drives, "drive_family", lambda *_: drives.pop())
    file = tmp_path / "kept" / "discs.npz"
    first, again = (gate_drives.driven_before("p.onnx", (), WORLDS, file) for _ in range(2))
    assert (first.as_it_is == again.as_it_is).all()
    assert (first.worse == again.worse).all()


def test_a_family_is_driven_no_farther_than_the_gate_would_look() -> None:
    """Enough is 1.13 % after two looks (ln(1.15/1.1) over 2.645 + 1.282); a tenth less is asked."""
    start = Look(0.0, 0.1)
    assert gate_drives.is_far_enough([start, Look(0.1, 0.0101)])
    assert not gate_drives.is_far_enough([start, Look(0.1, 0.0103)])


def test_a_pair_counts_no_better_than_two_drives_from_different_places() -> None:
    """1 % from 20,000 contacts of each, however alike the two are."""
    counts = np.full(WORLDS, 20.0)
    look = gate_drives.unpaired(look_at(counts, counts), Pair(counts, counts))
    assert look.error == pytest.approx(0.01, rel=1e-3)
    assert gate_drives.unpaired(Look(0.0, 0.3), Pair(counts, counts)).error == 0.3


def test_two_drives_of_one_policy_are_swapped_world_by_world() -> None:
    counts = np.arange(16.0).reshape(2, 4, 2)
    new, old = gate.alike(Driven(counts, counts), np.array([1, 0]), np.array([0, 1]))
    assert new.T.tolist() == [[1.0, 3.0, 5.0, 7.0], [8.0, 10.0, 12.0, 14.0]]
    assert old.T.tolist() == [[9.0, 11.0, 13.0, 15.0], [0.0, 2.0, 4.0, 6.0]]


def test_the_mixture_loses_just_what_is_asked_for() -> None:
    made = driven(4.0, 1.3)
    generator = np.random.default_rng(2)
    new, old = gate.worse(
        made,
        np.tile(np.arange(WORLDS), 40),
        generator.integers(2, size=40 * WORLDS),
        generator.random(40 * WORLDS),
        0.15,
    )
    assert new.sum(axis=1) / old.sum(axis=1) - 1.0 == pytest.approx(0.15, abs=0.01)


def test_alike_is_hardly_ever_an_alarm_and_a_plain_loss_is_found() -> None:
    families = {str(k): driven(2.0, 1.4, seed=k) for k in range(4)}
    said = [overall(gate.compare_alike(families, seed)) for seed in range(100)]
    assert said.count(Claim.LOSES) <= 5
    found = gate.found_in(families, "2", 0.3, comparisons=20)
    assert found is not None
    assert (found.found, found.kept) == (1.0, 0.0)


def test_a_loss_at_the_margin_is_rarely_called_one() -> None:
    """At 10 % itself "loses" is a false alarm: at most one in twenty, of four families."""
    families = {str(k): driven(2.0, 1.2, seed=k) for k in range(4)}
    found = gate.found_in(families, "1", gate.MARGIN, comparisons=100)
    assert found is not None
    assert found.found <= 0.05


def test_a_policy_that_did_not_lose_enough_is_not_judged() -> None:
    assert gate.found_in({"a": driven(2.0, 1.05)}, "a", 0.15, comparisons=1) is None
