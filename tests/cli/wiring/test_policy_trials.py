"""Every command that computes a policy can do so on the other backend, within a time limit."""

import json
from pathlib import Path

import pytest

from reflexarc.main import main
from reflexarc.wiring.policy_trials import try_policy
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.trial import spawned
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.looping_policies import FOR_EVER, looping


@pytest.fixture
def policy(tmp_path: Path) -> Path:
    """A policy that only onnxruntime computes."""
    path = tmp_path / "policy.onnx"
    path.write_bytes(looping(reference_contract(), 2))
    return path


COMMANDS = {
    "info": ("info", "POLICY", "--json"),
    "evaluate": ("evaluate", "POLICY", "--agents", "2", "--steps", "2", "--json"),
    "render": (
        "render",
        "reference-1",
        "-o",
        "OUT",
        "--policy",
        "POLICY",
        "--seconds",
        "0.5",
        "--json",
    ),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_policy_that_only_onnxruntime_computes_is_taken_with_the_flag(
    name: str, policy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = {"POLICY": str(policy), "OUT": str(tmp_path / "out.png")}
    words = [places.get(word, word) for word in COMMANDS[name]]
    assert main(words) == 2
    assert "use --backend onnxruntime" in capsys.readouterr().err.replace("\n", " ")
    assert main([*words, "--backend", "onnxruntime"]) == 0
    assert json.loads(capsys.readouterr().out)


def test_a_policy_that_hangs_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "reflexarc_runtime.loop.trials.trial.Trial.__init__.__defaults__", (0.5, spawned)
    )
    path = tmp_path / "policy.onnx"
    path.write_bytes(looping(reference_contract(), FOR_EVER))
    with pytest.raises(PolicyError, match="it hangs"):
        try_policy(path, "onnxruntime")


def test_results_of_the_one_backend_are_not_taken_for_those_of_the_other(policy: Path) -> None:
    usual, other = (Entrant("p", str(policy), backend=b) for b in ("numpy", "onnxruntime"))
    assert usual.content_hash() != other.content_hash() == other.content_hash()
