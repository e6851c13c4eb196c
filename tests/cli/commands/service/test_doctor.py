import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc.commands.service.doctor import DoctorCommand
from reflexarc.doctoring import lateness_trial
from reflexarc.doctoring.lateness_trial import Punctuality
from reflexarc.main import main
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_runtime.messages.spread import Spread
from support.policies import exported
from support.recordings import CONTRACT
from support.ros2_robot import free_port


@pytest.fixture
def quiet_machine(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, int]]:
    """One whose loop is 1 ms late at the 99.9th percentile; what was asked of it."""
    asked = []

    def try_lateness(
        rate_hz: float, seconds: float, fifo: int, policy: Path | None, backend: str
    ) -> Punctuality:
        asked.append((rate_hz, fifo))
        late = Spread(1000, 10_000, 100_000, 1_000_000, 1_000_000)
        return Punctuality(f"SCHED_FIFO {fifo}" if fifo else "ordinary", late, None, None)

    monkeypatch.setattr(lateness_trial, "try_lateness", try_lateness)
    return asked


def doctor(*words: str) -> int:
    return main(["doctor", "--port", str(free_port()), *words])


def test_a_machine_that_keeps_the_rate_is_well(quiet_machine, tmp_path, capfd):
    before = os.sched_getscheduler(0), os.sched_getaffinity(0)
    status = doctor("--record", str(tmp_path), "--json")
    said = json.loads(capfd.readouterr().out)
    assert (status, said["well"], said["rate_hz"]) == (0, True, 50.0)
    rate = said["rows"][-1]
    # 1.25 × (1000 + 100) µs
    assert (rate["name"], rate["health"]) == ("rate", "well")
    assert "ordinary 727 Hz, SCHED_FIFO 80 727 Hz" in rate["found"]
    assert [fifo for _, fifo in quiet_machine] == [0, 80]
    scheduling = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
    assert (scheduling, os.sched_getaffinity(0)) == before
    assert list(tmp_path.iterdir()) == []


def test_the_contracts_rate_is_asked_and_status_1_says_that_it_is_not_kept(
    quiet_machine, tmp_path, capfd
):
    policy = tmp_path / "policy.onnx"
    policy.write_bytes(exported(CONTRACT, 3, "Relu"))
    assert doctor(str(policy), "--rate", "800") == 1
    assert quiet_machine[0] == (800.0, 0)
    assert "BAD      rate: ordinary 727 Hz" in capfd.readouterr().out
    assert doctor(str(policy)) == 0
    assert quiet_machine[-1] == (CONTRACT.rate_hz, 80)


def test_a_rate_is_kept_by_who_keeps_a_quicker_one(quiet_machine, tmp_path, capfd):
    """Twenty ticks at 0.1 Hz would take longer than anybody waits for the trial."""
    policy = tmp_path / "policy.onnx"
    policy.write_bytes(exported(replace(CONTRACT, rate_hz=0.1), 3, "Relu"))
    assert doctor(str(policy)) == 0
    assert quiet_machine == [(1.0, 0), (1.0, 80)]
    assert "the contract's is 0.1" in capfd.readouterr().out


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_a_policy_faster_than_usual_is_measured_on_what_computes_it(backend, tmp_path):
    """Nothing moves meanwhile: no bounds hold."""
    fast = replace(
        CONTRACT, actions=(Action(CONTRACT.actions[0].name, 30.0, 0.0), *CONTRACT.actions[1:])
    )
    policy = tmp_path / "policy.onnx"
    policy.write_bytes(exported(fast, 3, "Relu"))
    found = lateness_trial.try_lateness(200.0, 0.1, 0, policy, backend)
    assert isinstance(found, Punctuality), found
    assert found.tick is not None


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (DoctorCommand(seconds=0.1), "--seconds: expected 0.5 to 600, got 0.1"),
        (DoctorCommand(rate=20_000.0), "--rate: expected 1 to 10000, got 20000"),
        (DoctorCommand(joining=Joining(port=70_000)), "--port: expected 1 to 65535, got 70000"),
        (DoctorCommand(joining=Joining(robot="a b")), "--robot: expected letters"),
        (DoctorCommand(Path("/absent.onnx"), joining=Joining()), "absent.onnx"),
    ],
)
def test_what_cannot_be_tried_is_refused_in_one_line(command, words):
    with pytest.raises(ReflexarcError, match=words) as refusal:
        command.run()
    assert isinstance(refusal.value, UsageError) or command.policy is not None
    assert "\n" not in str(refusal.value)


@pytest.mark.long
@pytest.mark.parametrize("tools", [True, False])
def test_a_real_machine_is_measured_with_its_tools_and_without(tools, tmp_path, monkeypatch):
    if not tools:
        monkeypatch.setenv("PATH", str(tmp_path))
    policy = tmp_path / "policy.onnx"
    policy.write_bytes(exported(CONTRACT, 3, "Relu"))
    found = lateness_trial.try_lateness(50.0, 0.5, 0, policy)
    assert isinstance(found, Punctuality)
    assert found.tick is not None
    assert found.beside is not None
    assert found.tick.count > 20
