"""Random pairs of contracts that differ in one field of the eye, or in none of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.contract.provenance import Provenance

FIELDS = (
    "rays",
    "fov_rad",
    "range_m",
    "shading",
    "eyes",
    "baseline_m",
    "channels",
    "samples",
    "beams",
)
"""Of an eye: all but how many pictures of it a policy sees at once."""
NOT_OF_THE_EYE = ("frames", "seed", "scores", "name")


@dataclass(frozen=True)
class Pair:
    """A body's contract and a runtime's."""

    field: str
    """In which they differ."""
    body: PolicyContract
    runtime: PolicyContract


def eye(draw: np.random.Generator) -> RetinaSpec:
    """A random eye, small enough to be simulated quickly."""
    return RetinaSpec(
        rays=int(draw.integers(2, 33)),
        fov_rad=float(draw.uniform(0.5, 6.0)),
        range_m=float(draw.uniform(1.0, 9.0)),
        shading=list(Shading)[draw.integers(2)],
        frames=int(draw.integers(1, 4)),
        eyes=int(draw.integers(1, 3)),
        baseline_m=float(draw.uniform(0.0, 0.3)),
        channels=(1, 3)[draw.integers(2)],
        samples=int(draw.integers(1, 5)),
        beams=list(BeamRule)[draw.integers(2)],
    )


def other_value(name: str, value: Any, draw: np.random.Generator) -> Any:
    """Another value of a field; of a number often one that is very near."""
    if name in ("fov_rad", "range_m", "baseline_m"):
        change = math.exp(draw.uniform(math.log(2e-5), 0.0))
        limit = 2 * math.pi if name == "fov_rad" else math.inf
        return value + change if value + change < limit else value - change
    if name == "rays":
        return (2 * value, value + 1, value - 1)[draw.integers(3)]
    choices: dict[str, list[Any]] = {
        "shading": [*Shading],
        "eyes": [1, 2],
        "channels": [1, 3],
        "samples": [*range(1, 9)],
        "beams": [*BeamRule],
        "frames": [*range(1, 5)],
    }
    others = [choice for choice in choices[name] if choice != value]
    return others[draw.integers(len(others))]


def other_contract(contract: PolicyContract, name: str, draw: np.random.Generator) -> Any:
    """A contract that differs in one thing."""
    if name == "seed":
        return replace(contract, provenance=Provenance(seed=int(draw.integers(1, 1000))))
    if name == "scores":
        return replace(contract, provenance=Provenance(scores={"contacts": draw.uniform()}))
    if name == "name":
        named = tuple(replace(a, name=f"{a.name} {draw.integers(9)}") for a in contract.actions)
        return replace(contract, actions=named, provenance=Provenance(preset="another"))
    value = other_value(name, getattr(contract.retina, name), draw)
    return replace(contract, retina=replace(contract.retina, **{name: value}))


def pairs(
    seed: int, count: int, names: tuple[str, ...] = FIELDS, bodies: int | None = None
) -> Iterator[Pair]:
    """So many pairs, which differ in each of these in turn.

    Args:
        seed: of what is drawn.
        count: how many.
        names: fields.
        bodies: how many bodies there are, each in as many pairs that follow each other.
    """
    draw = np.random.default_rng(seed)
    each = math.ceil(count / (bodies or count))
    slow = (Action("a", 0.2, 0.0), Action("b", 0.2, 0.1), Action("c", 0.2, -0.1))
    contract = PolicyContract()
    for number in range(count):
        if number % each == 0:
            contract = PolicyContract(retina=eye(draw), actions=slow)
        name = names[number % len(names)]
        yield Pair(name, contract, other_contract(contract, name, draw))
