"""A policy is tried in a process that can be ended."""

import hashlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.forked_process import ForkedProcess
from reflexarc_runtime.loop.trials.trial import Finding, Trial, TrialProcess, check_fits, spawned
from reflexarc_runtime.loop.trials.trial_process import main
from reflexarc_runtime.policy.policy import load_policy
from support.looping_policies import FOR_EVER, looping, vast_in_darkness
from support.policies import SMALL, exported

Begin = Callable[..., TrialProcess]


def forked(path: Path, backend: str, data: bytes | None = None) -> TrialProcess:
    return ForkedProcess(lambda: main(path, backend, data))


@pytest.fixture(params=[spawned, forked])
def begin(request: pytest.FixtureRequest) -> Begin:
    """Both ways to begin."""
    return request.param  # type: ignore[no-any-return]


def found(path: Path, backend: str, begin: Begin, loading_s: float = 60.0) -> Finding:
    with Trial(path, backend, loading_s, begin) as trial:
        return trial.finding()


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_a_good_policy_fits(tmp_path: Path, backend: str, begin: Begin):
    path = tmp_path / "policy.onnx"
    path.write_bytes(exported(SMALL))
    finding = found(path, backend, begin)
    assert 0 < finding.decision_ns < 1e9
    check_fits(Finding(finding.policy_hash, 1000), load_policy(path, backend))


def test_what_was_read_is_tried_and_the_file_is_not_read_again(tmp_path: Path, begin: Begin):
    path, data = tmp_path / "policy.onnx", exported(SMALL)
    path.write_bytes(exported(SMALL, seed=9))
    given = partial(begin, data=data)
    assert found(path, "numpy", given).policy_hash == hashlib.sha256(data).hexdigest()
    with pytest.raises(PolicyError, match=rf"^{path}: expected an ONNX model"):
        found(path, "numpy", partial(begin, data=b"no model"))


def test_one_that_never_returns_is_ended(tmp_path: Path, begin: Begin):
    path = tmp_path / "policy.onnx"
    path.write_bytes(looping(SMALL, FOR_EVER))
    began_s = time.monotonic()
    with pytest.raises(PolicyError, match=r"within 0\.5 s, got none: it hangs"):
        found(path, "onnxruntime", begin, 0.5)
    assert time.monotonic() - began_s < 60.0


def test_one_that_never_returns_in_darkness_is_ended_too(tmp_path: Path, begin: Begin):
    """Its golden vector is bright; whoever loads it asks it about darkness before its loop does."""
    path = tmp_path / "policy.onnx"
    path.write_bytes(looping(SMALL, FOR_EVER, at_intensity=0, golden_intensity=90))
    with pytest.raises(PolicyError, match=r"within 0\.5 s, got none: it hangs"):
        found(path, "onnxruntime", begin, 0.5)


def test_one_that_takes_all_memory_in_darkness_is_refused(tmp_path: Path, begin: Begin):
    path = tmp_path / "policy.onnx"
    path.write_bytes(vast_in_darkness(SMALL))
    with pytest.raises(PolicyError, match="in darkness"):
        found(path, "onnxruntime", begin)


def test_what_the_process_refuses_is_refused_in_its_words(tmp_path: Path, begin: Begin):
    path = tmp_path / "policy.onnx"
    with pytest.raises(PolicyError, match="cannot be read"):
        found(path, "numpy", begin)
    path.write_bytes(b"no model")
    with pytest.raises(PolicyError, match="expected an ONNX model"):
        found(path, "numpy", begin)


def test_a_decision_longer_than_the_period_is_refused_but_in_lockstep():
    policy = load_policy(exported(SMALL))
    slow = Finding(policy.policy_hash, 30_000_000)
    with pytest.raises(PolicyError, match=r"within 20 ms, the period at 50 Hz; got 30\.0 ms"):
        check_fits(slow, policy)
    check_fits(slow, policy, in_real_time=False)


def test_a_file_that_changed_after_its_trial_is_refused():
    with pytest.raises(PolicyError, match="changed"):
        check_fits(Finding("another", 1000), load_policy(exported(SMALL)))


def test_a_copy_that_breaks_or_is_ended_leaves_this_process_as_it_was(tmp_path: Path):
    def broken() -> None:
        print("ready", flush=True)
        os.kill(os.getpid(), signal.SIGSEGV)

    path = tmp_path / "policy.onnx"
    with (
        Trial(path, "numpy", begin=lambda *_: ForkedProcess(broken)) as trial,
        pytest.raises(PolicyError, match=r"broke \(status -11\)"),
    ):
        trial.finding()
    hanging = ForkedProcess(lambda: time.sleep(600))
    hanging.kill()
    assert hanging.wait() == -signal.SIGKILL
    hanging.stdout.close()
    hanging.kill()  # of what has ended, nothing


def test_what_a_copy_raises_is_not_raised_here():
    def raising() -> None:
        raise KeyboardInterrupt

    copy = ForkedProcess(raising)
    assert (copy.communicate()[0], copy.wait()) == ("", 1)


def test_only_a_process_with_one_thread_is_copied(tmp_path: Path):
    words = """
import sys, threading
from pathlib import Path
from reflexarc_runtime.loop.trials.forked_process import forked_if_alone
for _ in range(2):
    process = forked_if_alone(Path("none.onnx"), "numpy")
    print(type(process).__name__)
    process.kill()
    process.wait()
    threading.Thread(target=threading.Event().wait, daemon=True).start()
"""
    said = subprocess.run(
        [sys.executable, "-c", words], check=True, capture_output=True, text=True, timeout=100
    ).stdout
    assert said.split() == ["ForkedProcess", "Popen"]
