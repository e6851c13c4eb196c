"""Held actions and margins: the simulator, the loop and replay do the same for the same retinas."""

from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_runtime.sensing.senses import sense_for
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from support.policies import exported
from support.recordings import CONTRACT, ENCODING, KEY, drive, nominal, smooth_retinas
from support.rewriting import edit_decisions, rewrite

TICKS = 80


def of_simulator(policy: LoadedPolicy, retinas: np.ndarray, period_s: float = 0.02) -> list[int]:
    pilot = Pilot(policy, policy.contract, 1, period_s)
    return [int(pilot.act(retina[np.newaxis, np.newaxis])[0]) for retina in retinas]


def of_controller(policy: LoadedPolicy, retinas: np.ndarray) -> list[int]:
    """What the controller does once it drives, one retina a slot."""
    contract = policy.contract
    controller = Controller(policy, contract, sense_for("retina", contract.retina))
    state, actions, period_ns = State(), [], round(1e9 / contract.rate_hz)
    for slot, retina in enumerate(retinas):
        at_ns = slot * period_ns
        payload = encode_retina(retina, contract.retina, at_ns)
        message = Message(KEY, payload, ENCODING, pack_stamp(Stamp(slot, at_ns)), at_ns)
        state, decision = controller.step(state, Inputs((message,), slot), at_ns)
        assert decision.verdict is Verdict.OK
        actions.append(decision.action)
    return actions


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    hold_s=st.sampled_from([0.0, 0.02, 0.05, 0.1, 0.33]),
    margin=st.sampled_from([0.0, 0.1, 0.5, 1.0]),
    least_lead=st.sampled_from([0.0, 0.05, 0.5]),
)
def test_simulator_loop_and_replay_do_the_same(seed, hold_s, margin, least_lead, tmp_path_factory):
    contract = replace(CONTRACT, hold_s=hold_s, margin=margin, least_lead=least_lead)
    data = exported(contract, seed % 7, "Relu")
    path: Path = tmp_path_factory.mktemp("held") / "log.mcap"
    drive(path, data, nominal(TICKS, seed), TICKS)
    decisions = [t.decision for t in read_log(path).ticks() if t.decision.verdict == 1]
    retinas = smooth_retinas(TICKS, seed)[2:]  # two recover
    assert of_simulator(load_policy(data), retinas) == [d.action for d in decisions]
    assert replay(path).exit_status == 0


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
@pytest.mark.parametrize("hold_s", [0.3, 0.5])
def test_a_hold_is_as_long_at_any_rate(rate_hz, hold_s):
    contract = PolicyContract(
        retina=CONTRACT.retina,
        rate_hz=rate_hz,
        hold_s=hold_s,
        recovery_inputs=1,
        max_input_age_s=0.2,
    )
    policy = load_policy(exported(contract, 3, "Relu"))
    rng = np.random.default_rng(0)
    retinas = rng.integers(0, 256, (1000, *contract.retina.shape), np.uint8)
    winners = policy.decide(retinas[:, np.newaxis])[1]
    actions = of_controller(policy, retinas)
    assert actions == of_simulator(policy, retinas, 1.0 / rate_hz)
    lengths = [len(list(run)) for _, run in groupby(actions)][:-1]
    shortest_s = min(lengths) / rate_hz
    assert len(lengths) > 20
    assert shortest_s == pytest.approx(hold_s)
    assert len(list(groupby(winners))) > 1.5 * len(lengths)  # the policy itself flickers


def test_a_hold_that_was_not_kept_is_found_at_both_levels(tmp_path):
    """A tick that did its winner although another action was held is a difference."""
    contract = replace(CONTRACT, hold_s=0.2)
    drive(tmp_path / "log.mcap", exported(contract, 3, "Relu"), nominal(TICKS), TICKS)
    ticks = [t.decision for t in read_log(tmp_path / "log.mcap").ticks()]
    held = next(d.index for d in ticks if d.verdict == 1 and d.winner != d.action)

    def follow(decision):
        if decision.index == held:
            decision.action = decision.command.action = decision.winner

    path = rewrite(tmp_path / "log.mcap", tmp_path / "new.mcap", edit_decisions(follow))
    report = replay(path)
    assert report.exit_status == 1
    firsts = [level.first for level in report.levels]
    assert [f and (f.tick, f.path) for f in firsts] == [(held, "action"), (held, "action")]
