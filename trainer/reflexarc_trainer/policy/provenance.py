"""Provenance of a policy: configuration, versions and commit, but no date and no host name."""

import importlib.metadata
import platform
import subprocess
from pathlib import Path

from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_trainer.config.train_config import TrainConfig

_PACKAGES = ("reflexarc", "numba", "numpy", "onnx", "onnxruntime", "torch")


def provenance_of(config: TrainConfig, scores: dict[str, float]) -> Provenance:
    """The provenance that the contract of a trained policy carries."""
    return Provenance(
        preset=config.preset,
        seed=config.seed,
        config=config.resolved(),
        config_hash=config.hash,
        versions=versions(),
        commit=commit(),
        scores=scores,
    )


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that a result depends on."""
    return {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}}


def commit() -> str:
    """Commit of the git checkout that contains this package, or "" if none does."""
    folder = Path(__file__).resolve().parent
    # The file must be tracked: an environment may lie inside a checkout of something else.
    command = ["git", "-C", str(folder), "ls-files", "--error-unmatch", Path(__file__).name]
    if not _output(command):
        return ""
    return _output(["git", "-C", str(folder), "rev-parse", "HEAD"])


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "source"


def _output(command: list[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=5.0, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
