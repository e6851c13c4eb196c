"""Who is measured: a policy, the contract that it drives by, and where both come from.

A contender is named by a short text, so that any process can make it anew:

    runs/reflex-0/policy.onnx                   an exported file
    module:Class                                an object with `contract` and `decide`, or `driver`
                                                (`driving/driver.py`: it knows the simulation)
    blind, random                               an agent that never steers, and one that draws
"""

import importlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

if TYPE_CHECKING:
    from reflexarc_runtime.policy.policy import Policy, RememberingPolicy

BLIND, RANDOM = "blind", "random"
_RANDOM_SEED = 1


@dataclass(frozen=True)
class Contender:
    """Who drives."""

    name: str
    policy: "Policy | RememberingPolicy"
    contract: PolicyContract
    sees_ranges: bool = False
    """It was made for a range finder: for it every obstacle is white and the background black."""
    is_guarded: bool = False
    """It drives behind the guard that a robot has."""

    @property
    def turns(self) -> bool:
        """Whether left and right turn its body: it has no x of its own."""
        return any(action.angular_radps for action in self.contract.actions)


def contender_of(source: str, *, is_guarded: bool = False) -> Contender:
    """The contender of a text.

    Args:
        source: see above.
        is_guarded: whether it drives behind a guard.

    Raises:
        ReflexarcError: no such file, module or class; or what is there is no policy.
    """
    if source == BLIND:
        return Contender(source, BlindPolicy(), reference_contract())
    if source == RANDOM:
        return Contender(source, RandomPolicy(_RANDOM_SEED), reference_contract())
    if ":" in source and not Path(source).exists():
        return _by_name(source, is_guarded)
    loaded = load_policy(Path(source), bounds=None)
    return Contender(source, loaded, loaded.contract, is_guarded=is_guarded)


def _by_name(source: str, is_guarded: bool) -> Contender:
    made = _made(source)
    contract = getattr(made, "contract", None)
    can = any(callable(getattr(made, name, None)) for name in ("decide", "driver"))
    if not (isinstance(contract, PolicyContract) and can):
        raise UsageError(f"{source}: expected an object with `contract` and `decide`, or `driver`")
    sees = getattr(getattr(made, "ORIGIN", None), "sees", "")
    return Contender(source, made, contract, str(sees) == "ranges", is_guarded)


def _made(source: str) -> Any:
    name, _, kind = source.partition(":")
    try:
        return getattr(importlib.import_module(name), kind)()
    except (ImportError, AttributeError, TypeError) as error:
        wanted = "expected module:Class, a class that takes no arguments"
        raise UsageError(f"{source}: {wanted}: {error}") from None
