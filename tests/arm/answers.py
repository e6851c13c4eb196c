"""The same questions for any machine: logs to replay, networks to compute, functions to evaluate.

    python tests/arm/answers.py QUESTIONS ANSWERS LOG…

QUESTIONS is the folder that `questions.py` filled; ANSWERS gets `answers.json` and `answers.npz`.
"""

import contextlib
import io
import json
import platform
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc.main import main as reflexarc
from reflexarc_runtime.policy.policy import load_policy

BACKENDS = ("numpy", "onnxruntime")


def sigmoid(x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """As the NumPy backend computes it, in float64 (n,)."""
    tail = np.exp(-np.abs(x))
    return np.where(x >= 0.0, 1.0, tail) / (1.0 + tail)


FUNCTIONS: dict[str, Callable[..., npt.NDArray[np.float64]]] = {
    "tanh": np.tanh,
    "exp": np.exp,
    "sigmoid": sigmoid,
    "softplus": lambda x: np.logaddexp(0.0, x),
}


def answer(questions: Path, answers: Path, logs: Sequence[str]) -> None:
    """Answer everything, and write the answers."""
    answers.mkdir(parents=True, exist_ok=True)
    said = {"machine": describe_machine(), "replays": {log: _replays(log) for log in logs}}
    (answers / "answers.json").write_text(json.dumps(said), encoding="utf-8")
    values: dict[str, Any] = {**_q_values(questions), **_function_values(questions)}
    np.savez(answers / "answers.npz", **values)


def describe_machine() -> dict[str, str]:
    """What this machine says that it is."""
    simd: Any = np.show_config(mode="dicts")
    return {
        "machine": platform.machine(),
        "python": platform.python_version(),
        "libc": " ".join(platform.libc_ver()),
        "numpy": version("numpy"),
        "simd": " ".join(simd["SIMD Extensions"].get("found", [])) or "baseline",
        "onnxruntime": version("onnxruntime"),
    }


def _replays(log: str) -> dict[str, tuple[int, str]]:
    """Exit status and report of `reflexarc replay`, on each backend."""
    return {backend: _replay(log, backend) for backend in BACKENDS}


def _replay(log: str, backend: str) -> tuple[int, str]:
    report = io.StringIO()
    with contextlib.redirect_stdout(report), contextlib.redirect_stderr(report):
        status = reflexarc(["replay", log, "--backend", backend])
    return status, report.getvalue()


def _q_values(questions: Path) -> dict[str, npt.NDArray[np.float32]]:
    """Q-values of each network on the NumPy backend, float32 (n, actions)."""
    retinas = np.load(questions / "retinas.npy")
    files = sorted(questions.glob("*.onnx"))
    return {file.stem: load_policy(file).decide(retinas)[0] for file in files}


def _function_values(questions: Path) -> dict[str, npt.NDArray[np.float64]]:
    """Values of each function, float64 (n,)."""
    sums = np.load(questions / "sums.npy")
    return {f"function {name}": function(sums) for name, function in FUNCTIONS.items()}


if __name__ == "__main__":
    answer(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
