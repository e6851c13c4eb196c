"""The specification of whoever is measured."""

from dataclasses import replace
from pathlib import Path

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_sim_bridge.evaluation.protocol.agent_facts import agent_of, group_of
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.moving_like import moving_like, who_words
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

MUSEUM = Path(__file__).parents[3] / "golden" / "museum"


def test_trained_file_tells_preset_seed_eye_and_motion() -> None:
    rover = Entrant("rover", str(MUSEUM / "schema-2" / "rover.onnx"))
    agent = agent_of(rover.contender(), rover.source, rover.content_hash())
    assert (agent.preset, agent.seed, agent.turns) == ("rover", 0, True)
    assert agent.group.startswith("rover@")
    assert agent.tuned.startswith("trained: rover")
    assert "rad/s" in agent.motion
    assert agent.eye.startswith("eye rays=")


def test_seeds_of_one_configuration_are_one_group_and_no_others() -> None:
    def of(seed: int, gamma: float, preset: str = "p") -> str:
        config = {"seed": seed, "gamma": gamma}
        return group_of(Provenance(preset, seed, config, "hash"))

    assert of(0, 0.9) == of(1, 0.9)
    assert of(0, 0.9) != of(0, 0.8)
    assert of(0, 0.9) != of(0, 0.9, "q")


def test_limits_are_shared_by_those_who_move_alike_whatever_they_see() -> None:
    plain = reference_contract()
    other_eye = replace(plain, retina=replace(plain.retina, rays=64), margin=0.1, hold_s=0.1)
    wide = replace(plain, body=BodySpec(Footprint(radius_m=0.2)))
    fast = replace(plain, rate_hz=100.0)
    motion = moving_like(plain, Setting.ROBOT)
    assert moving_like(other_eye, Setting.ROBOT) == motion
    for one in (wide, fast):
        assert moving_like(one, Setting.ROBOT) != motion
        assert moving_like(one, Setting.FIELD) == moving_like(plain, Setting.FIELD)
    assert who_words(motion) == "1 m/s ahead, 1 m/s aside, 50 Hz, point"
    words = who_words(moving_like(wide, Setting.ROBOT))
    assert words == "1 m/s ahead, 1 m/s aside, 50 Hz, round, 0.2 m"
