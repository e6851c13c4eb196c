"""The guard in simulation: as on a robot, and what it is worth."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.choice import choose
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import ContractError, WorldError
from reflexarc_runtime.guard import SHARES, Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import sense_for
from reflexarc_sim_bridge.evaluation.driving.crowd_guard import CrowdGuard, slowed
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.shapes import Discs
from reflexarc_sim_bridge.worlds.world import Chassis, World
from support.policies import exported
from support.sensing import ENCODING, KEY, MS

CONTRACT = PolicyContract(retina=RetinaSpec(rays=16), recovery_inputs=1)
PERIOD_S = 0.02


def retinas(ticks: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    waves = 195 + 55 * np.sin(np.arange(ticks)[:, None] / 9 + rng.uniform(0, 2.0, 16))
    return np.clip(waves, 0, 254).astype(np.uint8).reshape(ticks, 1, 16, 1)


def speeds_of_controller(policy, contract, known, seen):
    sense = sense_for("retina", contract.retina, guarded=True)
    guard = Guard.for_contract(known, contract)
    controller = Controller(policy, contract, sense, "", guard=guard)
    state, speeds = State(), []
    for slot, retina in enumerate(seen):
        at_ns = slot * 20 * MS
        payload = encode_retina(retina, contract.retina, at_ns)
        message = Message(KEY, payload, ENCODING, pack_stamp(Stamp(slot, at_ns)), at_ns)
        state, decision = controller.step(state, Inputs((message,), slot), at_ns)
        command = decision.command
        speeds.append((command.linear_mps, command.lateral_mps, command.angular_radps))
    return speeds


@pytest.mark.parametrize("hold_s", [0.0, 0.1])
@pytest.mark.parametrize("may_slow", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_a_simulated_agent_does_what_the_loop_does(seed, may_slow, hold_s):
    contract = replace(CONTRACT, hold_s=hold_s)
    policy = load_policy(exported(contract, seed))
    known = GuardSettings(footprint=Footprint(0.1), may_slow=may_slow, deceleration_mps2=2.0)
    seen = retinas(150, seed)
    crowd = CrowdGuard(known, contract, PERIOD_S)
    pilot = Pilot(policy, contract, 1, PERIOD_S, crowd)
    table = [(a.linear_mps, a.lateral_mps, a.angular_radps) for a in crowd.contract.actions]
    simulated = [table[int(pilot.act(retina[np.newaxis, np.newaxis])[0])] for retina in seen]
    assert simulated == speeds_of_controller(policy, contract, known, seen)
    assert crowd.did.decisions == 150
    assert crowd.did.guarded + crowd.did.stuck > 5


def test_the_table_of_motions_holds_every_share_and_standstill():
    actions = slowed(CONTRACT).actions
    assert len(actions) == 3 * len(SHARES) + 1
    assert [a.linear_mps for a in actions[::3]] == [*SHARES, 0.0]
    assert actions[-1].stands


def test_what_cannot_be_guarded_is_refused():
    with pytest.raises(ContractError, match="2 eyes"):
        CrowdGuard(GuardSettings(), PolicyContract(retina=RetinaSpec(eyes=2)), 0.1)
    many = tuple(Action(str(i), 1.0, 0.0) for i in range(16))
    with pytest.raises(WorldError, match="at most 15 actions, got 16"):
        CrowdGuard(GuardSettings(), PolicyContract(actions=many), 0.1)


@pytest.mark.parametrize("policy", [BlindPolicy(), RandomPolicy(1)])
def test_behind_a_guard_whatever_drives_meets_no_post_that_its_rays_see(policy):
    body = BodySpec(Footprint(radius_m=0.2))
    contract = PolicyContract(retina=RetinaSpec(rays=176), body=body)
    posts = Scatter(0.1, shapes=(Discs((0.05, 0.05)),))
    world = World("posts", layers=(posts,), chassis=Chassis(radius_m=0.2))

    def score(guard):
        return measure(policy, contract, agents=32, steps=200, discard=0, world=world, guard=guard)

    free, guarded = score(None), score(GuardSettings.of(contract))
    assert free.contacts > 10
    assert guarded.contacts == 0
    assert guarded.guarded > 0.0
    assert guarded.distance_m > 0.8 * free.distance_m


def test_without_a_guard_nothing_changes():
    pilot = Pilot(BlindPolicy(), CONTRACT, 2, PERIOD_S)
    assert pilot.act(retinas(2, 0)[:, np.newaxis]).tolist() == [0, 0]
    assert choose(None, (0.0, 1.0), 1, 0, 0, 0.0).action == 1
    assert Verdict.GUARDED not in (Verdict.OK, Verdict.STUCK)
