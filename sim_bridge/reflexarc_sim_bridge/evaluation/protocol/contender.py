"""Who is measured: a policy, the contract that it drives by, and where both come from.

A contender is named by a short text, so that any process can make it anew:

    runs/reflex-0/policy.onnx                   an exported file
    module:Class                                an object with `contract` and `decide`, or `driver`
                                                (`driving/driver.py`: it knows the simulation)
    mine.py:Class                               the same, from a file that is on no path
    blind, random                               an agent that never steers, and one that draws
"""

import importlib
import sys
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import ReflexarcError, UsageError, first_line
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.policy import Backend
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

if TYPE_CHECKING:
    from reflexarc_runtime.policy.policy import Policy, RememberingPolicy

BLIND, RANDOM = "blind", "random"
_RANDOM_SEED = 1
_PYTHON = ".py"


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


def contender_of(
    source: str, *, is_guarded: bool = False, backend: Backend | str = Backend.NUMPY
) -> Contender:
    """The contender of a text.

    Args:
        source: see above.
        is_guarded: whether it drives behind a guard.
        backend: what computes it, if it is a file.

    Raises:
        ReflexarcError: no such file, module or class; or what is there is no policy.
    """
    if source == BLIND:
        return Contender(source, BlindPolicy(), reference_contract())
    if source == RANDOM:
        return Contender(source, RandomPolicy(_RANDOM_SEED), reference_contract())
    if ":" in source and not Path(source).exists():
        return _by_name(source, is_guarded)
    loaded = load_tried_policy(Path(source), backend)
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
    name, _, kind = source.rpartition(":")
    try:
        return getattr(_module(name), kind)()
    except ReflexarcError:
        raise
    except Exception as error:  # somebody else's code runs here
        wanted = "expected module:Class or file.py:Class, a class that takes no arguments"
        said = f"{type(error).__name__}: {first_line(error)}"
        raise UsageError(f"{source}: {wanted}; got {said}") from None


def _module(name: str) -> ModuleType:
    if not name.endswith(_PYTHON):
        return importlib.import_module(name)
    spec = spec_from_file_location(Path(name).stem, name)
    if spec is None or spec.loader is None:
        raise UsageError(f"{name}: expected a file of Python code")
    module = module_from_spec(spec)
    sys.modules.setdefault(spec.name, module)  # dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module
