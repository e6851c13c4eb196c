"""An agent that moves house is where one would be that had lived there from the start."""

import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.foxglove_messages import encode_scene
from reflexarc_sim_bridge.body.gate.limits import Motion
from reflexarc_sim_bridge.worlds.files import world_named

NEAR = PolicyContract()
TURNING = (Action("ahead", 1.0, 0.0, 0.0), Action("turn", 0.5, 0.0, 1.0))
FAR = PolicyContract(
    retina=RetinaSpec(rays=24, fov_rad=2.0, range_m=9.0, shading=Shading.COLOUR, frames=3),
    actions=TURNING,
    max_input_age_s=0.3,
)

OTHER = replace(NEAR, retina=RetinaSpec(rays=24, shading=Shading.COLOUR, frames=3))
"""It reaches as far as the first one: its obstacles are listed with the same roundings."""


def body_of(contract: PolicyContract, name: str, rate_hz: float = 50.0) -> Body:
    return Body(world_named(name).drawn(3), contract, rate_hz, 3, 1)


def driven(body: Body, steps: int, seed: int) -> None:
    """Ahead, sideways and in curves."""
    draw = np.random.default_rng(seed)
    for _ in range(steps):
        ahead, left, turn = draw.uniform((0.5, -1.0, -1.0), (1.0, 1.0, 1.0))
        body.move(Motion(ahead, left, turn))


def state_of(body: Body) -> tuple[object, ...]:
    row = body.simulation.params.agents.state[0].copy()
    row["looks"] = 0
    return row.item(), body.contacts, encode_scene(body.simulation.outlines_near(0), 0)


@pytest.mark.parametrize("name", ["reference-1", "crossing", "randomised", "corridor-20"])
@pytest.mark.parametrize(("first", "second"), [(NEAR, OTHER), (OTHER, NEAR)])
def test_it_stands_sees_and_drives_on_as_one_that_always_had_that_eye(
    name: str, first: PolicyContract, second: PolicyContract
):
    former, always, after = body_of(first, name), body_of(second, name), body_of(second, name)
    driven(former, 700, seed=1)
    driven(always, 700, seed=1)
    after.take_over(former)
    assert after.place == former.place == always.place
    assert after.place.x_m > 1.0
    assert state_of(after) == state_of(always)
    for seed in range(40):
        assert np.array_equal(after.see(), always.see())
        driven(after, 5, seed)
        driven(always, 5, seed)
    assert state_of(after) == state_of(always)


@pytest.mark.parametrize("name", ["reference-1", "crossing", "randomised", "corridor-20"])
def test_with_an_eye_of_another_reach_the_same_to_within_roundings(name: str):
    former, always, after = body_of(NEAR, name), body_of(FAR, name), body_of(FAR, name)
    driven(former, 700, seed=1)
    driven(always, 700, seed=1)
    after.take_over(former)
    for seed in range(10):
        assert (after.place.x_m, after.place.y_m) == pytest.approx(
            (always.place.x_m, always.place.y_m), abs=1e-5
        )
        differ = after.see() != always.see()
        assert np.mean(differ) < 0.05
        driven(after, 3, seed)
        driven(always, 3, seed)


def test_with_another_rate_the_world_goes_on_at_the_same_time():
    slow = replace(NEAR, rate_hz=20.0)
    former, after = body_of(NEAR, "crossing"), body_of(slow, "crossing", 20.0)
    driven(former, 500, seed=1)
    after.take_over(former)
    steps = {body: int(body.simulation.params.agents.state["steps"][0]) for body in (former, after)}
    assert (steps[former], steps[after]) == (500, 200)  # 10 s
    assert after.place == former.place
    assert math.isclose(*(float(b.simulation.distance_m[0]) for b in (former, after)))


def test_counts_are_kept():
    former, after = body_of(NEAR, "reference-1"), body_of(FAR, "reference-1")
    for _ in range(1500):
        former.move(Motion(1.0))
    former.held_back = 7
    assert former.contacts > 0
    after.take_over(former)
    assert (after.contacts, after.held_back) == (former.contacts, 7)
    assert after.simulation.contacts[0] == former.simulation.contacts[0]
