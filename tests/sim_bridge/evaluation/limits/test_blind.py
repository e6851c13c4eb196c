"""A blind agent in a contender's place."""

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.limits.blind import blind_like
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy

CELL = SuiteCell("0.10", "reference-1", clutter=0.1)
FAMILIES = (SuiteFamily("f", cells=(CELL,)),)
SUITE = Suite("t", 1, worlds=2, lanes=2, free_paths=2.0, families=FAMILIES)


def test_it_has_the_body_the_rate_and_the_speeds_of_the_other_and_never_steers():
    contract = PolicyContract(
        actions=sideways_actions(0.7, 0.3), rate_hz=20.0, body=BodySpec(Footprint(0.15))
    )
    track = drive(blind_like(Contender("r", RandomPolicy(1), contract)), CELL, SUITE, Setting.ROBOT)
    circumstances = track.circumstances
    assert circumstances.dt_s == 1.0 / 20.0
    assert circumstances.radius_m == 0.15
    assert circumstances.forward_mps == 0.7
    assert not track.actions.any()
    is_free = ~track.met[:-1]
    assert (track.y_m[1:] == track.y_m[:-1])[is_free].all()
