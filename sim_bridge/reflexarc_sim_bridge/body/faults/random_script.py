"""Fault scripts drawn from a seed: among ten consecutive seeds every kind of fault occurs once.

Every script is without faults in its first 0.9 s and its last second, so that a run shows the drive
before the faults and after them. Clocks step by at least 0.3 s: a smaller step cannot be told from
a slow sensor.
"""

from pathlib import Path

import numpy as np

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.faults.script import (
    KINDS,
    ClockStep,
    Delay,
    Duplication,
    Fault,
    FaultScript,
    Freezing,
    Frozen,
    Jitter,
    Loss,
    Malformation,
    Malformed,
    Reordering,
    SecondSender,
    Silence,
)
from reflexarc_sim_bridge.body.faults.script_file import read_script

REPEAT_S = 4.0
"""Period after which a random script begins again."""

_SEED_PREFIX = "seed:"
_LONGEST_STEP_S = 1e5
_WINDOWS = ((0.9, 0.15, 0.65), (1.7, 0.15, 0.65))
"""(begin, shortest, longest), seconds: two faults of the kind, one after the other."""


def script_named(name: str) -> FaultScript:
    """The script for the value of `--faults`: `seed:17`, or a TOML file.

    Raises:
        UsageError: no such file, or not a script.
    """
    if not name.startswith(_SEED_PREFIX):
        return read_script(Path(name))
    number = name.removeprefix(_SEED_PREFIX)
    if not (number.isascii() and number.isdigit()):
        raise UsageError(f"--faults: expected seed:N with N from 0 on, got {name!r}")
    return random_script(int(number))


def random_script(seed: int) -> FaultScript:
    """The script of a seed: two faults of one kind, sometimes with a third beside the first.

    Raises:
        UsageError: a seed beyond 64 bits.
    """
    FaultScript((), seed)  # refuses a seed that no script can have
    rng = np.random.default_rng(seed)
    kind = kind_of_seed(seed)
    spans = [(begin, _between(rng, low, high)) for begin, low, high in _WINDOWS]
    # which of a kind's variants comes is counted, not drawn: all of them occur
    variants = [2 * (seed // len(KINDS)) + nth for nth in range(len(spans))]
    faults = [
        _draw(kind, span, variant, rng) for span, variant in zip(spans, variants, strict=True)
    ]
    return FaultScript((*faults, *_companion(kind, spans[0], rng)), seed, REPEAT_S)


def kind_of_seed(seed: int) -> str:
    """The kind that a seed's script is about."""
    return list(KINDS)[seed % len(KINDS)]


def _draw(kind: str, span: tuple[float, float], variant: int, rng: np.random.Generator) -> Fault:
    match kind:
        case "delay":
            return Delay(*span, _between(rng, 0.02, 0.5))
        case "jitter":
            return Jitter(*span, _between(rng, 0.02, 0.3))
        case "loss":
            return Loss(*span, _between(rng, 0.3, 1.0))
        case "duplication":
            return Duplication(*span, _between(rng, 0.3, 1.0), int(rng.integers(2, 6)))
        case "reordering":
            return Reordering(*span, _between(rng, 0.2, 1.0), _between(rng, 0.02, 0.2))
        case "freezing":
            return Freezing(*span, list(Frozen)[variant % len(Frozen)])
        case "malformed":
            share = 1.0 if rng.random() < 0.5 else _between(rng, 0.2, 1.0)
            return Malformed(*span, list(Malformation)[variant % len(Malformation)], share)
        case "silence":
            return Silence(*span)
        case "second-sender":
            return SecondSender(*span, 0.0 if variant % 3 == 0 else _step_s(rng))
        case _:
            return ClockStep(*span, _step_s(rng))


def _companion(kind: str, span: tuple[float, float], rng: np.random.Generator) -> tuple[Fault, ...]:
    """A second fault at the same time, in some of the scripts."""
    if kind == "second-sender" and rng.random() < 0.5:
        return (Silence(*span),)  # only the other one speaks
    if rng.random() > 0.4:
        return ()
    return (
        (
            Loss(*span, _between(rng, 0.1, 0.5)),
            Jitter(*span, _between(rng, 0.01, 0.06)),
            Duplication(*span, 0.5),
        )[int(rng.integers(3))],
    )


def _step_s(rng: np.random.Generator) -> float:
    sign = 1.0 if rng.random() < 0.5 else -1.0
    return sign * float(np.exp(rng.uniform(np.log(0.3), np.log(_LONGEST_STEP_S))))


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, high))
