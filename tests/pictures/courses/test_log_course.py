from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.courses.log_course import course_of
from reflexarc_sim_bridge.body.foxglove_messages import encode_scene
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.silhouettes import Area
from support.policies import exported
from support.recordings import CONTRACT, drive, nominal
from support.round_room import ROOM_M, message, pose


def test_rays_out_of_a_log_are_as_long_as_its_retinas_say(turning: Path):
    course = course_of(read_log(turning), 10.0)
    rays_m = [snapshot.rays_m for snapshot in course.snapshots if snapshot.rays_m is not None]
    assert len(rays_m) > 3
    np.testing.assert_allclose(rays_m[-1], ROOM_M, atol=5.0 / 255)
    assert course.snapshots[0].retina is None
    assert (course.snapshots[1].x_m, course.snapshots[1].y_m) == (3.0, -2.0)


def test_a_film_of_a_log_shows_the_obstacles_that_the_body_told_of_last(tmp_path: Path):
    simulation = Simulation(WORLDS["crossing"].drawn(0), CONTRACT, np.array([0], np.uint64))
    told = [simulation.outlines_near(0)]
    for _ in range(20):
        simulation.step(np.zeros(1, np.int64))
    told.append(simulation.outlines_near(0))
    scenes = [SceneUpdate.FromString(encode_scene(outlines, 0)) for outlines in told]
    before = [message("pose", pose(0.1, 0.0, 0.0), slot) for slot in (1, 11)]
    before += [message("scene", scene, slot) for scene, slot in zip(scenes, (1, 11), strict=True)]
    path = tmp_path / "told.mcap"
    drive(path, exported(CONTRACT), nominal(20), 20, before=before)
    course, everywhere = course_of(read_log(path), 10.0), Area(-99.0, 99.0, -99.0, 99.0)
    for time_s, outlines in ((0.0, told[0]), (0.1, told[0]), (0.2, told[1])):
        shown = course.scenery.within(everywhere, time_s)
        middles = sorted(tuple(s.corners_m.mean(axis=0)) for s in shown)
        expected = sorted((o.x_m, o.y_m) for o in outlines)
        np.testing.assert_allclose(middles, expected, atol=2.0**-9)  # as a scene says lengths
