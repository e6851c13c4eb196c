"""The headline score in one process, against what a whole run of the suite says."""

from pathlib import Path

import pytest

from reflexarc_sim_bridge.evaluation.protocol.contender import Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.evaluation.running.evaluate import evaluate
from reflexarc_sim_bridge.evaluation.running.headline import headline
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.small_suite import write_small_suite


@pytest.mark.parametrize("setting", Setting)
def test_it_is_what_a_run_of_the_suite_says(setting: Setting, tmp_path: Path) -> None:
    path, controllers = write_small_suite(tmp_path)
    mine, suite = contender_of(f"{controllers}:Mine"), suite_named(str(path))
    (card,) = score_cards(evaluate(mine.policy, suite, settings=(setting,), jobs=1))
    said = headline(mine, suite, setting)
    assert said == headline(mine, suite, setting) == card.headline.value
    assert said > 0.2


def test_an_agent_that_never_steers_has_nothing(tmp_path: Path) -> None:
    path, _ = write_small_suite(tmp_path)
    contender = Contender("x", BlindPolicy(), reference_contract())
    assert headline(contender, suite_named(str(path)), Setting.FIELD) == 0.0
