"""A log says where it was driven: the world of its `body` messages is the world of its retinas."""

import json
import signal
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_sim_bridge.body.body import rebuild
from reflexarc_sim_bridge.body.foxglove_messages import encode_scene
from support.processes import finished, reflexarc, started

FAMILY = """
name = "somewhere"
width_m = 12.0

[[layers]]
kind = "scatter"
density_per_m2 = { from = 0.2, to = 0.6 }

[[layers.shapes]]
kind = "discs"
radius_m = [0.15, 0.75]
"""
"""A world that has no name in this package, with a range from which the seed draws."""


def record(log: Path, policy: Path, port: int, *body: object) -> Log:
    """The log of a runtime in lockstep with a body that ends by itself."""
    words = ("run", policy, "--lockstep", "--port", port, "--record", log, "--json")
    with (
        started(*words) as runtime,
        started(*body, "--lockstep", "--port", port, "--json") as driven,
    ):
        finished(driven)
        finished(runtime, signal.SIGINT)
    return read_log(log)


def bodies(log: Log) -> list[BodyInfo | None]:
    return [decode_body(record.payload) for record in log.records("/robot0/body")]


@pytest.mark.long
def test_a_log_holds_the_world_that_it_was_driven_in_and_plays_it(
    policy: Path, port: int, tmp_path: Path
):
    world = tmp_path / "somewhere.toml"
    world.write_text(FAMILY)
    sim = ("sim", "--world", world, "--seed", 7, "--rate", 20, "--steps", 50)
    log = record(tmp_path / "drive.mcap", policy, port, *sim)
    info = bodies(log)[0]
    assert info is not None
    assert info == BodyInfo("somewhere", FAMILY, 7, 0, 1 / 20, BodyLimits(1.0, 1.0, 0.0))
    assert bodies(log) == [info] * 2  # 50 steps are 2.5 s; it is said every two

    body = rebuild(info, load_policy(policy).contract)
    first, image = next(iter(log.messages("/robot0/retina", RawImage)))
    assert np.frombuffer(image.data, np.uint8).tolist() == body.see().ravel().tolist()
    _, scene = next(iter(log.messages("/robot0/scene", SceneUpdate)))
    outlines = encode_scene(body.simulation.outlines_near(0), first.publish_ns)
    assert scene == SceneUpdate.FromString(outlines)
    assert scene.entities[0].cylinders

    played = record(tmp_path / "played.mcap", policy, port, "play", log.path)
    assert bodies(played) == bodies(log)
    told = json.loads(reflexarc("info", played.path, "--json").stdout)
    assert (told["body"]["world_text"], told["body"]["seed"]) == (FAMILY, 7)
