"""Networks of users, exported, run on both backends, recorded and replayed; or refused, and why.

    python tests/campaigns/architectures.py [--all] [--gains 0.1 1 10 100] [--seeds 1] [--ticks 40]

Each row is a kind of network whose random weights are multiplied by each gain: twenty kinds, or
with --all every one that `tests/support/architectures.py` has; of Stable-Baselines3, where it is
installed, PPO, DQN and A2C on observations from 0 to 255. A cell is the `q_tolerance` of the file,
with which the loop of `reflexarc run` made so many ticks on NumPy and as many on onnxruntime, and
each log was replayed; or the number of a refusal, whose words stand below the table. Exit status 1
if anything else came out of one.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

import numpy as np
import torch
from gymnasium import Env, spaces

from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.sb3_export import export_sb3
from support.architectures import ARCHITECTURES, contract_of, network
from support.recordings import RUN, drive, nominal

TWENTY = (
    *(f"MLP, {kind}" for kind in ("ReLU", "LeakyReLU", "ELU", "SELU", "GELU", "SiLU", "Tanh")),
    *(f"MLP, {kind}" for kind in ("Softplus", "Hardswish", "Mish")),
    "Conv1d",
    "Conv1d around a ring, groups",
    "Conv1d, BatchNorm, pools",
    "Dueling",
    "LayerNorm",
    "Residual",
    "Attention",
    "LogSoftmax head",
    "GRU cell",
    "LSTM cell",
)
OF_THE_LIBRARY = ("PPO", "DQN", "A2C")

Write = Callable[[Path], PolicyContract]


@dataclass
class Table:
    """What came out."""

    cells: list[str] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    exported: int = 0
    failed: int = 0

    def refused(self, words: str) -> str:
        """The number of a refusal."""
        self.refusals.append(words)
        return f"refused ({len(self.refusals)})"


def main() -> int:
    """Try all, and print the table."""
    given = _arguments()
    names = tuple(ARCHITECTURES) if given.all else TWENTY
    table, began_s = Table(), time.monotonic()
    print(f"| network | {' | '.join(f'gain {gain:g}' for gain in given.gains)} |")
    print(f"|---|{'---|' * len(given.gains)}")
    for name in (*names, *(OF_THE_LIBRARY if _has_library() else ())):
        cells = [_of_seeds(name, gain, given.seeds, given.ticks, table) for gain in given.gains]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
    for number, words in enumerate(table.refusals, start=1):
        print(f"({number}) {words}")
    took_s = time.monotonic() - began_s
    print(f"{table.exported} exported, run on both backends and replayed; ", end="")
    print(f"{len(table.refusals)} refused; {table.failed} failed; {took_s:.0f} s")
    return int(table.failed > 0)


def _of_seeds(name: str, gain: float, seeds: int, ticks: int, table: Table) -> str:
    return ", ".join(_tried(_writer(name, gain, seed), ticks, table) for seed in range(seeds))


def _tried(write: Write, ticks: int, table: Table) -> str:
    """Export one, run it, replay it; a cell of the table."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "policy.onnx"
        try:
            written = write(path)
        except PolicyError as error:
            return table.refused(str(error))
        try:
            for backend in ("numpy", "onnxruntime"):
                _drive_and_replay(path, backend, ticks)
        except Exception as error:  # the campaign counts whatever comes
            table.failed += 1
            return f"FAILED: {type(error).__name__}: {error}"
    table.exported += 1
    return f"{written.q_tolerance:.1e}"


def _drive_and_replay(policy: Path, backend: str, ticks: int) -> None:
    log = policy.with_suffix(f".{backend}.mcap")
    verdicts = drive(
        log, policy.read_bytes(), nominal(ticks), ticks, run=replace(RUN, backend=backend)
    )
    if verdicts["OK"] < ticks // 2:
        raise AssertionError(f"{dict(verdicts)} on {backend}")
    report = replay(log)
    if report.exit_status or report.levels[0].compared < ticks // 2:
        raise AssertionError(f"its log on {backend}: {report.verdict}")


def _writer(name: str, gain: float, seed: int) -> Write:
    if name in OF_THE_LIBRARY:
        return lambda path: export_sb3(_model(name, gain, seed), PolicyContract(), path)
    return lambda path: export(network(name, gain, seed), contract_of(name), path)


def _model(name: str, gain: float, seed: int) -> Any:
    import stable_baselines3 as library

    model = getattr(library, name)("MlpPolicy", _Shown(), seed=seed, device="cpu")
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.mul_(gain)
    return model


class _Shown(Env[Any, Any]):
    """Shows a retina of 16 bytes."""

    observation_space = spaces.Box(0, 255, (16,), np.uint8)
    action_space = spaces.Discrete(3)

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        return self.observation_space.sample(), {}

    def step(self, action: Any) -> Any:
        return self.observation_space.sample(), 0.0, False, False, {}


def _has_library() -> bool:
    try:
        import stable_baselines3  # noqa: F401  # only whether it is there
    except ModuleNotFoundError:
        return False
    return True


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--gains", type=float, nargs="+", default=[0.1, 1.0, 10.0, 100.0])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--ticks", type=int, default=40)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
