from dataclasses import replace

import pytest

from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.contract.swap_fit import check_takes_over
from reflexarc_runtime.errors import ContractError

RUNNING = PolicyContract()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"retina": RetinaSpec(rays=17)}, "rays=16"),
        ({"retina": RetinaSpec(frames=2)}, "frames: 1 → 2"),
        ({"rate_hz": 49.0}, "rate_hz: 50.0 → 49.0"),
        ({"max_input_age_s": 0.2}, "max_input_age_s: 0.1 → 0.2"),
        ({"actions": tuple(reversed(sideways_actions()))}, "stay, left, right → right, left, stay"),
        ({"safe_command": Action("crawl", 0.1, 0.0)}, "safe_command"),
        ({"state": StateSpec(2, (0.0, 0.0))}, "values remembered: 0 → 2"),
        ({"body": BodySpec(actuation_delay_s=0.2)}, "body"),
    ],
)
def test_a_policy_of_another_contract_is_refused_by_what_differs(change, words):
    with pytest.raises(ContractError, match="expected a policy that fits") as refusal:
        check_takes_over(replace(RUNNING, **change), RUNNING)
    assert words in str(refusal.value)


def test_other_speeds_holds_and_weights_are_its_own():
    quicker = replace(RUNNING, actions=sideways_actions(0.5, 2.0), hold_s=0.2, margin=0.1)
    check_takes_over(replace(quicker, recovery_inputs=9), RUNNING)
