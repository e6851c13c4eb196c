"""Arrays that a caller hands to a simulation: what is wrong with them, in one line."""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions
from reflexarc_runtime.errors import WorldError


def check_seeds(seeds: npt.NDArray[np.uint64]) -> None:
    """Refuse what is not one seed an agent.

    Raises:
        WorldError: another shape or type.
    """
    if seeds.ndim != 1 or len(seeds) == 0 or seeds.dtype != np.uint64:
        raise WorldError(f"seeds: expected uint64 (n,), got {seeds.dtype} {seeds.shape}")


def check_actions(actions: Actions, agents: int, known: int) -> None:
    """Refuse what is not one of the known actions for each agent.

    Raises:
        WorldError: another shape or type, or an action that is not known.
    """
    if actions.shape != (agents,) or actions.dtype != np.int64:
        got = f"{actions.dtype} {actions.shape}"
        raise WorldError(f"actions: expected int64 ({agents},), one an agent, got {got}")
    if actions.min() < 0 or actions.max() >= known:
        got = f"{actions.min()} to {actions.max()}"
        raise WorldError(f"actions: expected 0 to {known - 1}, the contract's, got {got}")


def check_same_form(
    name: str, got: npt.NDArray[np.generic] | None, mine: npt.NDArray[np.generic]
) -> None:
    """Refuse an array of a state that is missing or unlike this simulation's.

    Raises:
        WorldError: it is.
    """
    wanted = f"{mine.dtype} {mine.shape}"
    if got is None:
        raise WorldError(f"state.{name}: expected {wanted}, got nothing")
    if got.shape != mine.shape or got.dtype != mine.dtype:
        raise WorldError(
            f"state.{name}: expected {wanted}, got {got.dtype} {got.shape}; restore into the same "
            "world, contract and number of agents"
        )
