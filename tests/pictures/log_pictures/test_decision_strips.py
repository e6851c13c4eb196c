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


def test_what_was_decided_is_drawn_as_it_stands_in_the_log(turning: Path):
    log = read_log(turning)
    decisions, ticks = decisions_of(log), [tick.decision for tick in log.ticks()]
    assert decisions.actions.tolist() == [tick.action for tick in ticks]
    assert decisions.time_s[-1] == pytest.approx((ticks[-1].now_ns - ticks[0].now_ns) / 1e9)
    for row, values, tick in zip(decisions.retinas, decisions.q_values, ticks, strict=True):
        if tick.retina:
            assert bytes(row.astype(np.uint8)) == tick.retina
            assert values.tolist() == list(tick.q_values)
        else:
            assert np.isnan([*row, *values]).all()
