import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.evaluation import cover_profile
from reflexarc_sim_bridge.evaluation.cover_profile import BINS, CoverProfile, measure_profile, ratio
from reflexarc_sim_bridge.evaluation.fairness import WorldReport, check_world
from reflexarc_sim_bridge.worlds.files import parse_world, world_named
from reflexarc_sim_bridge.worlds.world import World

Floats = npt.NDArray[np.float64]

EMPTY = World("empty", width_m=20.0, layers=())


def quiet(done: int, of: int) -> None:
    pass


# The profile, on worlds whose cover is known


def painted(
    monkeypatch: pytest.MonkeyPatch, probability: Callable[[Floats], Floats | float]
) -> None:
    """Places are covered at random, by a probability that depends on y alone."""
    generator = np.random.default_rng(3)

    def covered(_world: object, _contract: object, _seed: int, places_m: Floats) -> object:
        return generator.random(len(places_m)) < probability(places_m[:, 1])

    monkeypatch.setattr(cover_profile, "covered", covered)


def test_independent_places_have_the_error_of_a_binomial(monkeypatch: pytest.MonkeyPatch) -> None:
    painted(monkeypatch, lambda y_m: 0.3)
    profile = measure_profile(EMPTY, range(64), quiet)
    # (1 − c) / (c n) = 0.01², shared among 64 seeds.
    columns = int(0.7 / 0.3 / 0.01**2 / 64)
    wanted = math.sqrt(0.7 / 0.3 / (64 * columns))
    assert profile.mean == pytest.approx(0.3, rel=5 * wanted / math.sqrt(BINS))
    assert profile.error.mean() == pytest.approx(wanted, rel=0.1)
    assert np.abs(profile.deviation / profile.error).max() < 4.5
    assert (profile.deviation**2).mean() == pytest.approx((profile.error**2).mean(), rel=0.8)


def test_a_side_without_cover_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    painted(monkeypatch, lambda y_m: np.where(y_m < 0.5, 0.03, 0.3))
    profile = measure_profile(EMPTY, range(16), quiet)
    mean = (0.03 + 39 * 0.3) / 40
    assert profile.cover[0] == pytest.approx(0.03, abs=0.005)
    assert profile.deviation[0] == pytest.approx(0.03 / mean - 1.0, abs=0.02)
    np.testing.assert_allclose(profile.deviation[1:], 0.3 / mean - 1.0, atol=0.06)


def test_bins_share_out_the_width() -> None:
    profile = CoverProfile(10.0, *np.zeros((3, 5)))
    assert profile.lateral_m.tolist() == [1.0, 3.0, 5.0, 7.0, 9.0]


def test_nothing_is_covered_evenly(monkeypatch: pytest.MonkeyPatch) -> None:
    painted(monkeypatch, lambda y_m: 0.0)
    profile = measure_profile(EMPTY, range(2), quiet)
    assert profile.mean == 0.0
    assert not profile.deviation.any()


def test_a_ratio_knows_its_own_error() -> None:
    generator = np.random.default_rng(5)

    def sample() -> tuple[float, float]:
        gone = generator.uniform(50.0, 150.0, 200)
        values, errors = ratio(generator.poisson(0.36 * gone)[:, np.newaxis].astype(float), gone)
        return float(values[0]), float(errors[0])

    ratios, errors = np.array([sample() for _ in range(500)]).T
    assert ratios.mean() == pytest.approx(0.36, abs=4 * ratios.std() / math.sqrt(500))
    assert errors.mean() == pytest.approx(ratios.std(), rel=0.1)


# Whole worlds


@pytest.fixture(scope="module")
def reference() -> WorldReport:
    return check_world(world_named("reference-1"), seeds=24)


@pytest.fixture(scope="module")
def legacy() -> WorldReport:
    return check_world(world_named("legacy"), seeds=24)


def test_the_reference_field_is_fair(reference: WorldReport) -> None:
    assert (reference.fair, reference.reasons, reference.notes) == (True, (), ())
    assert reference.cover == pytest.approx(1.0 - math.exp(-0.27), rel=0.02)
    assert reference.expected_blind_contacts_per_100m == pytest.approx(36.0)
    assert reference.blind_contacts_per_100m == pytest.approx(36.0, abs=5 * reference.blind_error)
    assert reference.blind_error < 0.4
    assert reference.mean_free_path_m == pytest.approx(100.0 / 36.0, rel=0.03)
    assert reference.clutter == pytest.approx(0.081)


def test_a_world_of_ten_kilometres_is_measured_as_any_other() -> None:
    text = 'name = "x"\nwidth_m = 10000.0\n[[layers]]\nkind = "scatter"\ndensity_per_m2 = 0.3'
    report = check_world(parse_world(text), seeds=2)
    mean_area_m2 = 0.9 * 0.75
    assert report.cover == pytest.approx(
        1.0 - math.exp(-0.3 * mean_area_m2), abs=4 * 0.012
    )  # of 2 · 52 · 40 places
    rate = report.expected_blind_contacts_per_100m
    assert rate is not None
    assert report.blind_contacts_per_100m == pytest.approx(rate, abs=5 * report.blind_error)


def test_the_papers_world_is_caught_as_unfair(legacy: WorldReport) -> None:
    assert not legacy.fair
    (reason,) = legacy.reasons
    assert reason.startswith("cover at the sides is ")
    assert reason.endswith("% of the mean: an agent can hide there")
    assert legacy.expected_blind_contacts_per_100m is None


def test_the_papers_world_has_the_profile_that_its_rule_makes(legacy: WorldReport) -> None:
    # Centres lie evenly between w/2 and W − w/2, so that one covers y with the probability
    # |[y − w/2, y + w/2] ∩ [w/2, W − w/2]| / (W − w); ρW E[l] of them a metre, a Poisson number.
    sizes_m = np.linspace(0.5, 1.5, 401)
    y_m = np.array(legacy.lateral_m)[:, np.newaxis] + np.linspace(-0.15, 0.15, 21)[np.newaxis]
    low_m = np.maximum(y_m[..., np.newaxis] - sizes_m / 2, sizes_m / 2)
    high_m = np.minimum(y_m[..., np.newaxis] + sizes_m / 2, 12.0 - sizes_m / 2)
    share = np.maximum(high_m - low_m, 0.0) / (12.0 - sizes_m)
    cover = 1.0 - np.exp(-0.30 * 12.0 * 1.0 * share.mean(axis=-1))
    expected, found = cover.mean(axis=1), np.array(legacy.profile)
    error = np.hypot(np.array(legacy.profile_error), 1e-3)
    assert np.abs((found - expected) / error).max() < 5.0


def test_a_gap_in_a_corridor_is_no_wall_and_walls_are_no_cover() -> None:
    text = 'name = "x"\nedges = "unbounded"\n[[layers]]\nkind = "corridor"\n[[layers]]\n'
    bare = check_world(parse_world(f'{text}kind = "scatter"\ndensity_per_m2 = 0.0'), seeds=4)
    assert (bare.cover, bare.fair) == (0.0, True)
    assert bare.blind_contacts_per_100m > 0.0


def test_a_family_is_measured_over_its_seeds() -> None:
    text = 'name = "x"\n[[layers]]\nkind = "scatter"\ndensity_per_m2 = { from = 0.2, to = 0.6 }'
    family = parse_world(text)
    report = check_world(family, seeds=16)
    densities = [family.drawn(seed).layers[0].density_per_m2 for seed in range(16)]  # type: ignore[union-attr]
    assert report.fair
    assert report.expected_blind_contacts_per_100m == pytest.approx(90.0 * np.mean(densities))
    expected_cover = np.mean(1.0 - np.exp(-0.675 * np.array(densities)))
    assert report.cover == pytest.approx(expected_cover, rel=0.03)


def test_an_empty_world_is_fair_and_says_that_nothing_is_met() -> None:
    report = check_world(EMPTY, seeds=2)
    assert report.fair
    assert (report.mean_free_path_m, report.blind_contacts_per_100m) == (None, 0.0)
    assert report.notes == ("an agent that never steers has no contacts here",)


def test_a_world_that_nobody_passes_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(World, "clutter", lambda self: 0.30)
    report = check_world(EMPTY, seeds=2)
    assert report.fair
    assert "clutter 0.30: above 0.25 contacts cannot be avoided for ever" in report.notes


def test_contacts_that_are_not_those_of_the_field_are_unfair(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(World, "blind_contacts_per_100m", property(lambda self: 40.0))
    report = check_world(EMPTY, seeds=2)
    assert not report.fair
    assert "2ρR says 40.0" in report.reasons[-1]


def test_of_ghosts_it_is_not_known_how_often_they_begin_to_touch() -> None:
    assert world_named("ghost").blind_contacts_per_100m is None


@pytest.mark.parametrize("seeds", [-1, 0, 1, 10_001])
def test_too_few_seeds_or_too_many_are_refused(seeds: int) -> None:
    with pytest.raises(WorldError, match="seeds: expected 2 to 10000"):
        check_world(EMPTY, seeds)


def test_progress_reaches_its_end_and_never_goes_back() -> None:
    told: list[float] = []
    check_world(EMPTY, 2, lambda done, of: told.append(done / of))
    assert told == sorted(told)
    assert told[-1] == 1.0
