import json
import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.figures import FIGURES, figures_of
from reflexarc_sim_bridge.evaluation.metrics.sums import PER_AGENT, sums_of
from reflexarc_sim_bridge.evaluation.metrics.track import Track
from reflexarc_sim_bridge.evaluation.protocol.results import Results, row_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from support.hand_tracks import figures, track_of


def drawn(seed: int, agents: int = 6, steps: int = 200) -> Track:
    generator, shape = np.random.default_rng(seed), (steps, agents)
    return track_of(
        steps,
        agents,
        met=generator.random(shape) < 0.02,
        y_m=generator.uniform(0.0, 20.0, shape),
        actions=generator.integers(0, 3, shape),
        clearance_m=generator.uniform(0.0, 2.0, shape),
        ahead_s=np.where(generator.random(shape) < 0.5, np.inf, generator.random(shape)),
    )


def test_sums_of_worlds_add_up_to_those_of_all_agents() -> None:
    track = drawn(1)
    one, three = sums_of(track), sums_of(replace(track, lanes=2))
    for name in PER_AGENT:
        assert len(three[name]) == 3
        np.testing.assert_allclose(three[name].sum(axis=0), one[name].sum(axis=0))


def test_rows_can_be_taken_together() -> None:
    first, second = drawn(1), drawn(2)
    joined = {
        name: np.concatenate([getattr(first, name), getattr(second, name)], axis=1)
        for name in ("x_m", "y_m", "heading_rad", "progress_m", "actions", "met")
    }
    rest = {
        name: np.concatenate([getattr(first, name), getattr(second, name)], axis=1)
        for name in ("clearance_m", "ahead_s")
    }
    whole = Track(first.circumstances, 12, **joined, **rest)
    assert figures(first, second) == pytest.approx(figures(whole), nan_ok=True)


def test_results_hold_histograms_through_json() -> None:
    row = row_of("x", Setting.FIELD, "f", "t", sums_of(drawn(3)))
    document = json.loads(json.dumps(Results("s", "v", rows=[row]).to_json(), allow_nan=False))
    again = Results.from_json(document).rows[0]
    assert again == row
    assert again.array("way_lives").shape == (1, 2, 41)
    assert figures_of([again]) == pytest.approx(figures_of([row]), nan_ok=True)


def test_of_no_rows_nothing_is_known() -> None:
    assert all(math.isnan(value) for value in figures_of([]).values())
    assert list(figures_of([])) == list(FIGURES)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_the_shortest_tracks_have_figures(steps: int) -> None:
    found = figures(track_of(steps))
    assert found["contacts_per_100m"] == 0.0
    assert found["farthest_m"] == pytest.approx(0.1 * (steps - 1))


def test_every_figure_says_what_it_is() -> None:
    for name, figure in FIGURES.items():
        assert figure.title, name
        assert "\n" not in figure.title
