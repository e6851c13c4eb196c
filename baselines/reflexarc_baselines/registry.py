"""All baselines by their names, each loaded when it is first asked for."""

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from reflexarc_baselines.baseline import Baseline, Remembering
from reflexarc_runtime.errors import UsageError

HOMES: Mapping[str, str] = MappingProxyType(
    {
        "braitenberg-2a": "anchors.braitenberg:Braitenberg2a",
        "braitenberg-2b": "anchors.braitenberg:Braitenberg2b",
    }
)
"""Name of a baseline → its module in this package, and its class."""


def baseline_named(name: str) -> Baseline | Remembering:
    """The baseline of a name, with the parameters that it ships with.

    Raises:
        UsageError: no baseline has this name.
    """
    module, _, kind = source_of(name).partition(":")
    made: Baseline | Remembering = getattr(import_module(module), kind)()
    return made


def source_of(name: str) -> str:
    """`module:Class` of a baseline, from which any process can make it.

    Raises:
        UsageError: no baseline has this name.
    """
    if name not in HOMES:
        raise UsageError(f"baseline: none is named {name!r}; known: {', '.join(HOMES)}")
    return f"reflexarc_baselines.{HOMES[name]}"
