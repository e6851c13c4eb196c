"""Every function of NumPy that a graph can be written from gives what NumPy gives.

Each case is exported, and so compared with itself on a thousand retinas, on both backends.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from reflexarc_baselines.baseline import Fidelity, Origin, Span
from reflexarc_baselines.exporting.array_rules import FUNCTIONS
from reflexarc_baselines.exporting.element_rules import UFUNCS
from reflexarc_baselines.exporting.exporting import export_baseline
from reflexarc_baselines.picking import picked
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

Case = Callable[[Any], Any]
ROW = np.linspace(-1.0, 2.0, 16, dtype=np.float32)


@dataclass(frozen=True)
class Computes:
    """T is a function of the rays, (n, 16), from 0 to 1."""

    ORIGIN: ClassVar[Origin] = Origin("none", Fidelity.OURS)
    SEARCHED: ClassVar[Mapping[str, Span]] = {}
    case: Case

    @property
    def contract(self) -> PolicyContract:
        """The reference field's."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Steer by it."""
        rays = retinas[:, -1, 0, :, 0].astype(np.float32) / np.float32(255.0)
        return steer(self.case(rays).astype(np.float32), 0.3)


ELEMENTS: dict[str, Case] = {
    "absolute": lambda x: np.abs(x[:, 0] - x[:, 1]),
    "add": lambda x: 1.0 + x[:, 0] + x[:, 1],
    "arccos": lambda x: np.arccos(x[:, 0] * 0.9),
    "arcsin": lambda x: np.arcsin(x[:, 0] * -0.9),
    "arctan": lambda x: np.arctan(x[:, 0]),
    "arctan2": lambda x: np.arctan2(x[:, 0] + 0.01, x[:, 1] - 0.503),
    "bitwise_and": lambda x: (x[:, 0] > 0.5) & (x[:, 1] > 0.5),
    "bitwise_or": lambda x: (x[:, 0] > 0.5) | (x[:, 1] > 0.5),
    "cos": lambda x: np.cos(x[:, 0] * 9.0),
    "divide": lambda x: x[:, 0] / (x[:, 1] + 1.0) + 2.0 / (x[:, 2].astype(np.int64) + 3),
    "equal": lambda x: x[:, 0] == 0.0,
    "exp": lambda x: np.exp(-x[:, 0]),
    "floor": lambda x: np.floor(x[:, 0] * 2.9),
    "greater": lambda x: x[:, 0] > 0.5,
    "greater_equal": lambda x: x[:, 0] >= 0.5,
    "hypot": lambda x: np.hypot(x[:, 0], x[:, 1]),
    "invert": lambda x: ~(x[:, 0] > 0.5),
    "less": lambda x: x[:, 0] < 0.5,
    "less_equal": lambda x: x[:, 0] <= 0.5,
    "log": lambda x: np.log(x[:, 0] + 1.0),
    "logical_and": lambda x: np.logical_and(x[:, 0] > 0.5, x[:, 1] > 0.5),
    "logical_not": lambda x: np.logical_not(x[:, 0] > 0.5),
    "logical_or": lambda x: np.logical_or(x[:, 0] > 0.5, x[:, 1] > 0.5),
    "matmul": lambda x: x @ ROW + (x @ np.stack([ROW, ROW], axis=1))[:, 1],
    "maximum": lambda x: np.maximum(x[:, 0], x[:, 1]),
    "minimum": lambda x: np.minimum(0.7, x[:, 1]),
    "multiply": lambda x: 2.0 * x[:, 0] * x[:, 1] * (x[:, 2] > 0.5),
    "negative": lambda x: -x[:, 0],
    "not_equal": lambda x: x[:, 0] != 0.0,
    "power": lambda x: x[:, 0] ** np.float32(1.7) + x[:, 1] ** 2,
    "remainder": lambda x: (7.3 * x[:, 0] + 0.1) % 2.0 + (x[:, 1] * 8.9).astype(np.int64) % 4,
    "sign": lambda x: np.sign(x[:, 0] - 0.5),
    "sin": lambda x: np.sin(9.0 * x[:, 0]),
    "sqrt": lambda x: np.sqrt(x[:, 0]),
    "square": lambda x: np.square(x[:, 0]),
    "subtract": lambda x: 1.0 - x[:, 0],
    "tanh": lambda x: np.tanh(x[:, 0]),
    "maximum.accumulate": lambda x: np.maximum.accumulate(x[:, :5], axis=1)[:, 3],
    "minimum.accumulate": lambda x: np.minimum.accumulate(x, axis=1) @ ROW,
}
ARRAYS: dict[str, Case] = {
    "all": lambda x: (x[:, :3] > 0.21).all(axis=1),
    "any": lambda x: np.any(x[:, :3] > 0.9, axis=1),
    "argmax": lambda x: (x > 0.5).argmax(axis=1),
    "argmin": lambda x: x.argmin(axis=1),
    "clip": lambda x: np.clip(x[:, 0], 0.2, 0.6),
    "concatenate": lambda x: np.concatenate([x, np.ones((len(x), 1))], axis=1)[:, -2:].sum(axis=1),
    "diff": lambda x: np.diff(x, axis=1).max(axis=1),
    "expand_dims": lambda x: np.expand_dims(x[:, 0], 1)[:, 0],
    "full_like": lambda x: np.full_like(x[:, 0], 0.4),
    "hstack": lambda x: np.hstack([x[:, :1] > 0.5, x[:, 1:2]]) @ np.float32([1.0, 2.0]),
    "max": lambda x: x.max(axis=1),
    "mean": lambda x: np.mean(x, axis=-1, dtype=np.float32),
    "min": lambda x: np.min(x, axis=1),
    "getitem": lambda x: (
        x[:, [3, 1]][..., 0]
        + x[:, ::-1][:, 2]
        + x[:, -3:-1].mean(axis=1)
        + x[:, None, 4:9:2][:, 0, 1]
    ),
    "ones_like": lambda x: x[:, 0] + np.ones_like(x[:, 0]),
    "pad": lambda x: np.pad(x, ((0, 0), (1, 2)), constant_values=0.5)[:, 16:].sum(axis=1),
    "reshape": lambda x: x.reshape(len(x), 4, -1)[:, 1].sum(axis=1),
    "roll": lambda x: np.roll(x, -3, axis=1) @ ROW,
    "stack": lambda x: np.stack([x[:, 0], np.zeros(len(x))], axis=1).max(axis=1),
    "sum": lambda x: x.sum(axis=1, dtype=np.float32),
    "take_along_axis": lambda x: (
        picked(ROW, x.argmax(axis=1))
        + np.take_along_axis(x, x.argmin(axis=1)[:, np.newaxis], axis=1)[:, 0]
    ),
    "where": lambda x: (
        np.where(x[:, 0] > 0.5, x[:, 1], -1.0) + np.where(x[:, 0] > 0.5, x[:, 1] > 0.3, True)
    ),
    "zeros_like": lambda x: x[:, 0] + np.zeros_like(x[:, 0]),
}


@pytest.mark.parametrize("name", [*ELEMENTS, *ARRAYS])
def test_a_graph_gives_what_numpy_gives(name: str, tmp_path: Path) -> None:
    case = (ELEMENTS | ARRAYS)[name]
    contract = export_baseline(Computes(case), name, tmp_path / "p.onnx")
    assert contract.q_tolerance < 1e-5
    assert len({*contract.golden.q_values}) > 1 or name == "full_like"


def test_every_rule_is_tried_here() -> None:
    parts = [each if isinstance(each, tuple) else (each,) for each in UFUNCS]
    ufuncs = {".".join((each[0].__name__, *each[1:])) for each in parts}
    assert set(ELEMENTS) == ufuncs
    assert set(ARRAYS) == {function.__name__.strip("_") for function in FUNCTIONS}


@pytest.mark.parametrize(
    ("case", "why"),
    [
        (lambda x: np.cumsum(x, axis=1)[:, 1], "numpy.cumsum"),
        (lambda x: np.sort(x, axis=1)[:, 1], "numpy.sort"),
        (lambda x: np.cbrt(x[:, 0]), "numpy.cbrt"),
        (lambda x: np.add.accumulate(x, axis=1)[:, 1], "numpy.add.accumulate"),
        (lambda x: np.add(x[:, 0], 1.0, where=x[:, 0] > 0.5), "into an array that is there"),
        (lambda x: x[x[:, 0] > 0.5][:, 0], "a choice of agents"),
        (lambda x: x[:, x[0] > 0.5][:, 0], "a choice of agents"),
        (lambda x: ROW[x.argmax(axis=1)], "a value as the index|numbers themselves"),
        (lambda x: x.reshape(4, -1)[:, 0], "a shape that mixes agents"),
        (lambda x: np.concatenate([x, x], axis=0)[:, 0], "numpy.concatenate of agents"),
    ],
)
def test_others_are_refused_by_name(case: Case, why: str, tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match=why):
        export_baseline(Computes(case), "other", tmp_path / "p.onnx")
