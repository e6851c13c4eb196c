"""Whatever a user gets wrong: one line on standard error, exit status 2, nothing left behind."""

import json
import socket
from collections.abc import Callable
from pathlib import Path

import onnx
import pytest

from reflexarc_runtime.contract.contract import METADATA_KEY, PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.text import seal
from support.policies import exported, network
from support.processes import reflexarc


@pytest.fixture
def files(policy: Path, tmp_path: Path) -> Path:
    """A folder of things that are not what they should be."""
    data = policy.read_bytes()
    (tmp_path / "policy.onnx").write_bytes(data)
    (tmp_path / "text.onnx").write_text("not a model")
    (tmp_path / "bare.onnx").write_bytes(network(PolicyContract()))
    (tmp_path / "cut.onnx").write_bytes(data[: len(data) // 2])
    (tmp_path / "operator.onnx").write_bytes(exported(PolicyContract(), activation="Shrink"))
    colours = PolicyContract(retina=RetinaSpec(shading=Shading.COLOUR))
    (tmp_path / "colours.onnx").write_bytes(exported(colours))
    (tmp_path / "tampered.onnx").write_bytes(tampered(data))
    (tmp_path / "newer.onnx").write_bytes(of_schema_9(data))
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "text.mcap").write_text("not a log")
    (tmp_path / "cut.mcap").write_bytes(golden_log().read_bytes()[:3000])
    (tmp_path / "folder").mkdir()
    return tmp_path


def golden_log() -> Path:
    return Path(__file__).parents[1] / "golden" / "nominal.mcap"


def tampered(data: bytes) -> bytes:
    model = onnx.ModelProto.FromString(data)
    weights = next(t for t in model.graph.initializer if t.name == "w2")
    raw = bytearray(weights.raw_data)
    raw[3] ^= 0x80  # the sign of the first weight
    weights.raw_data = bytes(raw)
    return model.SerializeToString()


def of_schema_9(data: bytes) -> bytes:
    """The same policy as a later version might write it."""
    model = onnx.ModelProto.FromString(data)
    (entry,) = (p for p in model.metadata_props if p.key == METADATA_KEY)
    document = json.loads(entry.value)
    del document["digest"]
    entry.value = seal({**document, "schema": 9})
    return model.SerializeToString()


CASES: dict[str, tuple[list[str], str]] = {
    "run: no such file": (["run", "none.onnx"], "cannot be read"),
    "run: a folder": (["run", "folder"], "cannot be read"),
    "run: no ONNX": (["run", "text.onnx"], "expected an ONNX model"),
    "run: cut off": (["run", "cut.onnx"], "cut.onnx"),
    "run: no contract": (["run", "bare.onnx"], "found none"),
    "run: newer schema": (["run", "newer.onnx"], "upgrade reflexarc"),
    "run: tampered": (["run", "tampered.onnx"], "golden vectors"),
    "run: operator": (["run", "operator.onnx"], "--backend onnxruntime"),
    "run: record into a file": (["run", "policy.onnx", "--record", "text.mcap/x.mcap"], "x.mcap"),
    "run: record over a log": (["run", "policy.onnx", "--record", "text.mcap"], "exists"),
    "run: robot": (["run", "policy.onnx", "--robot", "a/*"], "--robot"),
    "run: port": (["run", "policy.onnx", "--port", "0"], "--port"),
    "run: zenoh": (["run", "policy.onnx", "--zenoh", "none.json5"], "no such file"),
    "run: zenoh text": (["run", "policy.onnx", "--zenoh", "text.mcap"], "--zenoh"),
    "run: ticks": (["run", "policy.onnx", "--ticks", "0"], "--ticks"),
    "run: backend": (["run", "policy.onnx", "--backend", "tpu"], "backend"),
    "run: no ranges": (["run", "colours.onnx"], "--no-guard"),
    "run: margin": (["run", "policy.onnx", "--guard-margin-m", "0"], "guard.margin_m"),
    "run: radius": (["run", "policy.onnx", "--guard-radius-m", "-1"], "--guard-radius-m"),
    "run: flag": (["run", "policy.onnx", "--fast"], "--fast"),
    "run: nothing": (["run"], "reflexarc run"),
    "sim: world": (["sim", "--world", "mars"], "reference-1"),
    "sim: rate": (["sim", "--rate", "0"], "--rate"),
    "sim: rate nan": (["sim", "--rate", "nan"], "--rate"),
    "sim: seed": (["sim", "--seed", "-1"], "--seed"),
    "sim: steps": (["sim", "--steps", "0"], "--steps"),
    "sim: policy": (["sim", "--policy", "text.onnx"], "expected an ONNX model"),
    "train: preset": (["train", "--preset", "zebra"], "reflex"),
    "train: steps": (["train", "--steps", "0"], "steps"),
    "train: seed": (["train", "--seed", "-1"], "seed"),
    "train: out": (["train", "--steps", "10", "--out", "text.mcap/run"], "text.mcap"),
    "train: resume": (["train", "--out", "folder", "--resume"], "checkpoint"),
    "export: no checkpoint": (["export", "text.onnx", "-o", "o.onnx"], "text.onnx"),
    "export: missing": (["export", "none.npz", "-o", "o.onnx"], "none.npz"),
    "evaluate: agents": (["evaluate", "policy.onnx", "--agents", "0"], "--agents"),
    "evaluate: no policy": (["evaluate", "text.onnx"], "expected an ONNX model"),
    "replay: missing": (["replay", "none.mcap"], "cannot be read"),
    "replay: empty": (["replay", "empty.mcap"], "empty"),
    "replay: no MCAP": (["replay", "text.mcap"], "expected an MCAP file"),
    "replay: a policy": (["replay", "policy.onnx"], "expected an MCAP file"),
    "replay: cut off": (["replay", "cut.mcap"], "recover"),
    "replay: level": (["replay", "cut.mcap", "--level", "x"], "level"),
    "replay: policy": (["replay", str(golden_log()), "--policy", "text.onnx"], "text.onnx"),
    "recover: empty": (["recover", "empty.mcap", "-o", "o.mcap"], "empty"),
    "recover: no MCAP": (["recover", "text.mcap", "-o", "o.mcap"], "expected an MCAP file"),
    "recover: exists": (["recover", str(golden_log()), "-o", "text.mcap"], "exists"),
    "info: missing": (["info", "none"], "cannot be read"),
    "info: text": (["info", "text.onnx"], "expected an ONNX model"),
    "info: empty log": (["info", "empty.mcap"], "empty"),
    "demo: seconds": (["demo", "--seconds", "0"], "--seconds"),
    "demo: out": (["demo", "--out", "text.mcap/x"], "text.mcap"),
    "no such command": (["fly"], "fly"),
}


@pytest.mark.parametrize("name", list(CASES))
def test_wrong_input_is_said_in_one_line_with_exit_status_2(files: Path, name: str):
    words, expected = CASES[name]
    before = sorted(path.name for path in files.iterdir())
    done = reflexarc(*words, cwd=files)
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 2, done.stderr
    assert expected in lines[-1]
    assert len(lines) == 1, done.stderr
    assert "Traceback" not in done.stderr
    assert sorted(path.name for path in files.iterdir()) == before


def test_a_port_in_use_is_said(policy: Path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = reflexarc("sim", "--policy", policy, "--port", port)
    assert done.returncode == 2
    assert f"port {port}" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_an_unwritable_place_is_said(policy: Path, unwritable: Callable[[str], Path]):
    done = reflexarc("run", policy, "--record", unwritable("drive.mcap"))
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.fixture
def unwritable() -> Callable[[str], Path]:
    """A place where nobody can write, not even root: a folder of the kernel's."""
    return lambda name: Path("/proc/self") / name
