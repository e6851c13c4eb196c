"""Baselines as policy files: what the file decides is what the baseline decides."""

import dataclasses
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import onnx
import pytest

from reflexarc_baselines.anchors.braitenberg import Braitenberg2a
from reflexarc_baselines.baseline import Fidelity, Origin, Span
from reflexarc_baselines.exporting.exporting import export_baseline
from reflexarc_baselines.history.rob_nav import LEFT, RobNav
from reflexarc_baselines.registry import HOMES, PYTHON_ONLY, baseline_named
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import flips, within_tolerance
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

EXPORTED = sorted(HOMES.keys() - PYTHON_ONLY.keys())
AGENTS, STEPS = 300, 40


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where each baseline is exported once."""
    return tmp_path_factory.mktemp("baselines")


def exported(name: str, folder: Path, backend: str) -> LoadedPolicy:
    path = folder / f"{name}.onnx"
    if not path.exists():
        export_baseline(baseline_named(name), name, path)
    return load_policy(path, backend)


def drifting(contract: PolicyContract) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """What agents see step by step; the same rows come from near to far: (steps, agents, …)."""
    rng = np.random.default_rng(3)
    shape = (AGENTS, *contract.retina.stack_shape)
    brightest = rng.integers(0, 256, shape) * (rng.random(shape) < 0.4)
    shares = np.linspace(0.0, 1.0, STEPS).reshape(-1, *[1] * len(shape))
    return np.rint(brightest * shares).astype(np.uint8)


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
@pytest.mark.parametrize("name", EXPORTED)
def test_the_file_decides_as_the_baseline(name: str, backend: str, folder: Path) -> None:
    policy, baseline = exported(name, folder, backend), baseline_named(name)
    contract: PolicyContract = policy.contract
    at_rate = {"period_s": 1.0 / contract.rate_hz} if hasattr(baseline, "period_s") else {}
    own: Any = dataclasses.replace(baseline, **at_rate)  # type: ignore[type-var]  # a protocol
    memories = np.tile(np.array(contract.state.start_value, np.float32), (AGENTS, 1))
    for retinas in drifting(contract):
        expected = own.decide(retinas, memories) if memories.size else own.decide(retinas)
        got = policy.decide(retinas, memories) if memories.size else policy.decide(retinas)
        assert within_tolerance(got[0], expected[0], contract.q_tolerance)
        assert not flips(got[1], expected[1], expected[0], contract.q_tolerance).any()
        if memories.size:
            is_same = got[1] == expected[1]
            assert within_tolerance(got[2][is_same], expected[2][is_same], contract.q_tolerance)
            memories = expected[2]


SILENT = {"flow-balance", "flow-balance-always", "flow-largest", "flow-correlator"}
ROUGH = {"potential-field", "vfh-plus", *SILENT}
"""Forces of 10⁵ that cancel; openings on opposite sides that cost the same; the balance of two
sides that are next to silent."""


@pytest.mark.parametrize("name", sorted({*EXPORTED} - ROUGH))
def test_no_jump_hangs_on_rounding(name: str, folder: Path) -> None:
    """Else the bound, which counts what is on the other side of a jump, would be the largest."""
    assert exported(name, folder, "numpy").contract.q_tolerance < 3e-4


@pytest.mark.parametrize("name", sorted(PYTHON_ONLY))
def test_what_stays_in_python_is_refused_by_name(name: str, tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match=f"baseline {name}: .* cannot be written as a graph"):
        export_baseline(baseline_named(name), name, tmp_path / "p.onnx")
    assert not list(tmp_path.iterdir())


def test_the_file_says_what_it_is(folder: Path) -> None:
    provenance = exported("braitenberg-2a", folder, "numpy").contract.provenance
    assert provenance.preset == "baseline braitenberg-2a"
    assert "power=2.0" in provenance.config["parameters"]
    assert provenance.versions["onnx"] == onnx.__version__
    other = dataclasses.replace(Braitenberg2a(), power=3.0)
    export_baseline(other, "braitenberg-2a", folder / "other.onnx")
    again = load_policy(folder / "other.onnx").contract.provenance
    assert again.config_hash != provenance.config_hash


def test_the_same_baseline_gives_the_same_bytes(folder: Path) -> None:
    for path in (folder / "first.onnx", folder / "second.onnx"):
        export_baseline(RobNav(), "rob-nav", path)
    assert (folder / "first.onnx").read_bytes() == (folder / "second.onnx").read_bytes()


def test_seconds_are_decisions_of_the_exported_rate(tmp_path: Path) -> None:
    """Level 1 may last 2 R / w = 0.42 s: 5 decisions at 10 Hz, 21 at 50 Hz; one is being made."""
    retinas = np.full((1, *reference_contract().retina.stack_shape), 250, np.uint8)
    for rate_hz, decisions in ((10.0, 5), (50.0, 21)):
        contract = export_baseline(RobNav(), "rob-nav", tmp_path / "p.onnx", rate_hz=rate_hz)
        policy = load_policy(tmp_path / "p.onnx")
        assert policy.contract.rate_hz == contract.rate_hz == rate_hz
        _, _, following = policy.decide(retinas, np.zeros((1, 4), np.float32))
        assert following[0, LEFT] == decisions - 1


@dataclass(frozen=True)
class Crooked:
    """Decides by what no graph can hold, or otherwise at each call."""

    ORIGIN: ClassVar[Origin] = Origin("none", Fidelity.OURS)
    SEARCHED: ClassVar[Mapping[str, Span]] = {}
    fault: str = ""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Go wrong."""
        rays = retinas[:, -1, 0, :, 0].astype(np.float32)
        match self.fault:
            case "branch":
                return steer(rays[:, 0] if rays[0, 0] > 5.0 else rays[:, 1])
            case "assignment":
                rays[:, 0] = 1.0
            case "agents":
                return steer(rays[:, 0] - rays[:, 0].mean(axis=0))
            case "batch":
                return steer(rays[:, 0] + np.arange(len(rays), dtype=np.float32))
            case "bytes":
                return steer((retinas[:, 0, 0, 0, 0] + retinas[:, 0, 0, 1, 0]).astype(np.float32))
            case "numbers":
                return steer(np.asarray(rays)[:, 0])
        return steer(rays[:, 0])


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        ("branch", "a choice of agents cannot"),
        ("assignment", "an assignment to elements cannot"),
        ("agents", "numpy.mean over all agents cannot"),
        ("bytes", "arithmetic of bytes cannot"),
        ("numbers", "asks for the numbers themselves cannot"),
        ("batch", "do not agree"),
    ],
)
def test_what_a_graph_cannot_hold_is_refused(fault: str, why: str, tmp_path: Path) -> None:
    export_baseline(Crooked(), "crooked", tmp_path / "good.onnx")
    with pytest.raises(PolicyError, match=why):
        export_baseline(Crooked(fault), "crooked", tmp_path / "p.onnx")
    assert [path.name for path in tmp_path.iterdir()] == ["good.onnx"]


@dataclass(frozen=True)
class Fickle(Crooked):
    """Decides otherwise when it is asked with numbers."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Lie."""
        wish = retinas[:, -1, 0, 0, 0].astype(np.float32)
        return steer(wish + np.float32(isinstance(retinas, np.ndarray)))


def test_a_file_that_would_decide_otherwise_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match="NumPy and decide do not agree"):
        export_baseline(Fickle(), "fickle", tmp_path / "p.onnx")
    assert not list(tmp_path.iterdir())


def test_exporting_loads_no_torch(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path\n"
        "from reflexarc_baselines.exporting.exporting import export_baseline\n"
        "from reflexarc_baselines.registry import baseline_named\n"
        "export_baseline(baseline_named('subsumption'), 'subsumption', Path(sys.argv[1]))\n"
        "print([m for m in ('torch', 'matplotlib', 'zenoh', 'mcap') if m in sys.modules])"
    )
    words = [sys.executable, "-c", code, str(tmp_path / "p.onnx")]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_memories_that_nobody_reached_make_no_error() -> None:
    """A log may bring any: levels and times that are none of its own."""
    rng = np.random.default_rng(1)
    memories: Memories = rng.normal(scale=9.0, size=(64, 4)).astype(np.float32)
    retinas = rng.integers(0, 256, (64, *RobNav().contract.retina.stack_shape), np.uint8)
    assert np.isfinite(RobNav().decide(retinas, memories)[2]).all()
