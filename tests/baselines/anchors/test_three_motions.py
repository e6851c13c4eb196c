import numpy as np
import pytest

from reflexarc_baselines.anchors.three_motions import ThreeMotions
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure


def seeing(**rays_m: float) -> RetinaBatch:
    retina = np.zeros((1, 1, 1, 16, 1), np.uint8)
    for ray, distance_m in rays_m.items():
        retina[0, 0, 0, int(ray[1:]), 0] = round(255 * (1.0 - distance_m / 5.0))
    return retina


def test_each_motion_is_free_as_far_as_the_shorter_of_the_two_rays_beside_its_heading() -> None:
    """Ahead lies between rays 7 and 8, 45° to the left between 3 and 4 (50.6° and 39.4°), 45° to
    the right between 11 and 12. What the others meet is none of a motion's business."""
    eye = seeing(r0=0.5, r3=1.0, r4=2.0, r7=4.0, r8=3.0, r10=0.5, r11=1.5, r12=2.5)
    q_values, actions = ThreeMotions(rays=2, preference_m=0.25).decide(eye)
    assert q_values[0].tolist() == pytest.approx([3.25, 1.0, 1.5], abs=0.01)
    assert actions.tolist() == [0]


@pytest.mark.parametrize(("preference_m", "winner"), [(0.4, 1), (0.6, 0)])
def test_it_leaves_its_way_for_more_than_its_preference(preference_m: float, winner: int) -> None:
    eye = seeing(r7=1.0, r8=1.0, r3=1.5, r4=1.5, r11=1.2, r12=1.2)
    assert ThreeMotions(rays=2, preference_m=preference_m).decide(eye)[1].tolist() == [winner]


def test_nothing_in_sight_is_no_reason_to_step_aside() -> None:
    assert ThreeMotions().decide(seeing())[1].tolist() == [0]


def test_twelve_lines_make_a_tenth_of_the_contacts_of_random_motion() -> None:
    policy = ThreeMotions()
    assert measure(policy, policy.contract, agents=128, steps=200).contacts_per_100m < 0.1 * 48.0
