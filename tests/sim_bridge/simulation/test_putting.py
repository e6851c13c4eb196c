"""An agent that is put somewhere sees and does what one would that had driven there."""

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.gate.limits import Motion
from reflexarc_sim_bridge.simulation.putting import put_at
from reflexarc_sim_bridge.worlds.files import world_named

CONTRACT = PolicyContract()


def body_in(name: str) -> Body:
    return Body(world_named(name).drawn(3), CONTRACT, 50.0, 3)


@pytest.mark.parametrize("name", ["reference-1", "crossing", "corridor-20", "plane"])
@pytest.mark.parametrize("steps", [1, 400])
def test_it_goes_on_as_the_one_that_drove_there(name: str, steps: int):
    there, draw = body_in(name), np.random.default_rng(steps)
    for _ in range(steps):
        there.move(Motion(1.0, *draw.uniform(-1.0, 1.0, 1)))
    put = body_in(name)
    place = there.place
    put_at(put.simulation, place.x_m, place.y_m, place.heading_rad, steps)
    # Being put changes neither speeds nor the stream of random numbers.
    for speed in ("linear_mps", "lateral_mps", "angular_radps", "draws"):
        state = there.simulation.params.agents.state[speed]
        put.simulation.params.agents.state[speed] = state
    for _ in range(50):
        np.testing.assert_array_equal(put.see(), there.see())
        motion = Motion(1.0, *draw.uniform(-1.0, 1.0, 1))
        assert (put.move(motion) is None) == (there.move(motion) is None)
        assert put.place.x_m == pytest.approx(there.place.x_m, abs=1e-9)
        assert put.place.y_m == pytest.approx(there.place.y_m, abs=1e-9)


def test_what_moves_in_its_world_is_where_it_is_at_that_time():
    early, late = body_in("crossing"), body_in("crossing")
    for body, steps in ((early, 0), (late, 500)):
        place = body.place
        put_at(body.simulation, place.x_m, place.y_m, place.heading_rad, steps)
    assert (early.see() != late.see()).any()
