import numpy as np

from reflexarc_sim_bridge.worlds.seeds import (
    TRAINING_SEEDS,
    VALIDATION_SEEDS,
    test_seeds,
    training_seeds,
    validation_seeds,
)


def test_the_three_splits_share_no_seed() -> None:
    tests = set(test_seeds(5000).tolist())
    assert len(tests) == 5000
    assert not tests & set(TRAINING_SEEDS)
    assert not tests & set(VALIDATION_SEEDS)
    assert not set(TRAINING_SEEDS) & set(VALIDATION_SEEDS)


def test_more_test_seeds_begin_with_the_fewer() -> None:
    np.testing.assert_array_equal(test_seeds(7), test_seeds(20)[:7])


def test_splits_start_again_after_their_last_seed() -> None:
    assert validation_seeds(1002).tolist()[999:] == [10_999, 10_000, 10_001]
    assert training_seeds(3).tolist() == [0, 1, 2]
    assert training_seeds(3).dtype == test_seeds(3).dtype == np.uint64
