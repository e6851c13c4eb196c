import json
import math
import os
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from matplotlib.image import imread
from PIL import Image, ImageSequence

from reflexarc.main import main
from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.courses.course import Area
from reflexarc_pictures.courses.log_course import course_of
from reflexarc_pictures.courses.world_course import drive_in_world
from reflexarc_pictures.courses.world_scenery import WorldScenery
from reflexarc_pictures.log_pictures.decision_strips import decisions_of
from reflexarc_pictures.log_pictures.floor_plan import beam_ends, floor_plan_of
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract import PolicyContract, RetinaSpec
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_sim_bridge.body.foxglove_messages import encode_scene
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.policies import exported
from support.recordings import CONTRACT, MS, PERIOD_NS, RUN, START_NS, drive, nominal

from support.round_room import ROOM_M, TICKS, message, pose, scan, turning_log


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
    course = drive_in_world(source, reference_contract(), to_the_left, 0, 30.0)
    assert len(course.snapshots) == 301
    way_m = np.array([(snapshot.x_m, snapshot.y_m) for snapshot in course.snapshots])
    steps_m = np.hypot(*np.diff(way_m, axis=0).T)
    put = np.array([snapshot.put for snapshot in course.snapshots[1:]])
    np.testing.assert_allclose(steps_m[~put], math.hypot(0.1, 0.1), rtol=1e-6)
    assert way_m[:, 1].max() > 20.0
    assert put.sum() == len(course.contacts) > 0
