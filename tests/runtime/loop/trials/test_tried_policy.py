"""What onnxruntime shall compute is tried in a process of its own; the NumPy backend needs none."""

from pathlib import Path

import pytest

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials import trial
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from support.hostile_policies import POLICIES
from support.policies import SMALL, exported


def test_it_comes_back_loaded(tmp_path: Path) -> None:
    path = tmp_path / "policy.onnx"
    path.write_bytes(exported(SMALL))
    assert load_tried_policy(path, "onnxruntime").backend == "onnxruntime"


def test_no_process_is_started_for_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object, **__: object) -> None:
        raise AssertionError("a process")

    monkeypatch.setattr(trial.subprocess, "Popen", none)
    assert load_tried_policy(exported(SMALL), "numpy").backend == "numpy"
    with pytest.raises(AssertionError, match="a process"):
        load_tried_policy(exported(SMALL, seed=77), "onnxruntime")


def test_the_same_file_is_tried_once(monkeypatch: pytest.MonkeyPatch) -> None:
    data, begun, popen = exported(SMALL, seed=78), [], trial.subprocess.Popen

    def counted(*how: object, **more: object) -> object:
        begun.append(how)
        return popen(*how, **more)

    monkeypatch.setattr(trial.subprocess, "Popen", counted)
    for _ in range(2):
        load_tried_policy(data, "onnxruntime")
    assert len(begun) == 1


def test_more_memory_than_it_may_is_refused_before_this_process_takes_it() -> None:
    with pytest.raises(PolicyError, match=r"policy: the graph does not run on onnxruntime: .*Mul"):
        load_tried_policy(POLICIES["an outer product"](), "onnxruntime")


@pytest.mark.long
@pytest.mark.parametrize("name", ["a loop of 2⁶²", "functions that call each other"])
def test_what_hangs_is_refused_in_time(name: str) -> None:
    with pytest.raises(PolicyError, match="policy: expected a policy that loads and decides with"):
        load_tried_policy(POLICIES[name](), "onnxruntime")
