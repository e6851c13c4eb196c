"""What a policy computes for given inputs: proof, at load, that its weights are intact."""

from dataclasses import dataclass
from functools import partial

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import ContractError

_require = partial(require, error=ContractError)


@dataclass(frozen=True)
class GoldenSequence:
    """Retina stacks that follow each other, for a policy with a memory, from its start value on."""

    retinas: tuple[tuple[int, ...], ...]
    """Each one a flattened stack (frames, eyes, rays, channels), values 0 to 255."""
    q_values: tuple[tuple[float, ...], ...]
    """Float32 values; their decimal form restores the same bits."""
    actions: tuple[int, ...]
    """The winners."""
    end: tuple[float, ...]
    """The memory after the last one, float32."""


@dataclass(frozen=True)
class GoldenVectors:
    """Retina stacks with the Q-values and actions that the trainer computed for them.

    The runtime reproduces them at load on the backend that it will use, or refuses to start.
    """

    retinas: tuple[tuple[int, ...], ...] = ()
    """Each one a flattened stack (frames, eyes, rays, channels), values 0 to 255."""
    q_values: tuple[tuple[float, ...], ...] = ()
    """Float32 values; their decimal form restores the same bits."""
    actions: tuple[int, ...] = ()
    sequences: tuple[GoldenSequence, ...] = ()
    """Of a policy with a memory; its vectors above are computed from its start value."""


def check_golden(golden: GoldenVectors, retina_values: int, actions: int, memory: int) -> None:
    """Check that golden vectors have the sizes of a contract.

    Args:
        golden: vectors and sequences.
        retina_values: values of one stack.
        actions: how many actions there are.
        memory: values of the policy's memory; 0 without one.

    Raises:
        ContractError: a list is too long or too short, or a value is out of range.
    """
    _check("golden", golden, retina_values, actions)
    for number, sequence in enumerate(golden.sequences):
        where = f"golden.sequences[{number}]"
        _check(where, sequence, retina_values, actions)
        _require(len(sequence.end) == memory, f"{where}.end", f"{memory} values", sequence.end)


def _check(
    where: str, golden: GoldenVectors | GoldenSequence, retina_values: int, actions: int
) -> None:
    count = len(golden.retinas)
    lengths = (len(golden.q_values), len(golden.actions))
    _require(lengths == (count, count), where, f"{count} of each", lengths)
    fits = all(0 <= action < actions for action in golden.actions)
    _require(fits, f"{where}.actions", f"0 to {actions - 1}", "others")
    for retina, q_values in zip(golden.retinas, golden.q_values, strict=True):
        size = len(retina)
        _require(size == retina_values, f"{where}.retinas", f"{retina_values} values each", size)
        in_range = all(0 <= value <= 255 for value in retina)
        _require(in_range, f"{where}.retinas", "values 0 to 255", "others")
        size = len(q_values)
        _require(size == actions, f"{where}.q_values", f"{actions} each", size)
