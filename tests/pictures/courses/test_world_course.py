import math

import numpy as np
import pytest

from reflexarc_pictures.courses.world_course import drive_in_world
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


class ConstantPolicy:
    """Always does the same."""

    def __init__(self, action: int) -> None:
        self._action = action

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        n = len(retinas)
        return np.zeros((n, 3), np.float32), np.full(n, self._action)


def test_where_the_world_begins_anew_the_way_goes_on():
    source = WORLDS["reference-1"]
    to_the_left = ConstantPolicy(1)
    course = drive_in_world(source, Contender("left", to_the_left, reference_contract()), 0, 30.0)
    assert len(course.snapshots) == 301
    way_m = np.array([(snapshot.x_m, snapshot.y_m) for snapshot in course.snapshots])
    steps_m = np.hypot(*np.diff(way_m, axis=0).T)
    put = np.array([snapshot.put for snapshot in course.snapshots[1:]])
    np.testing.assert_allclose(steps_m[~put], math.hypot(0.1, 0.1), rtol=1e-6)
    assert way_m[:, 1].max() > 20.0
    assert put.sum() == len(course.contacts) > 0


@pytest.mark.parametrize("rays", [5, 16])
def test_behind_a_scanner_every_beam_is_drawn_where_it_looks(rays: int):
    eye = RetinaSpec(rays=rays, beams=BeamRule.SECTOR_MINIMUM)
    straight_on = Contender("straight on", ConstantPolicy(0), reference_contract(eye))
    course = drive_in_world(WORLDS["scanned"], straight_on, 0, 0.5)
    for snapshot in course.snapshots:
        assert snapshot.rays_m is not None
        assert snapshot.rays_m.shape == course.eye.bearings_rad.shape
    beams = np.degrees(course.eye.bearings_rad) + 90.0
    assert len(np.unique(np.round(beams, 6))) == 181
    np.testing.assert_allclose(beams, np.round(beams), atol=1e-6)
