"""The body: worlds, eyes, motion and environments. Nothing compiled is loaded until it is used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reflexarc_sim_bridge.environment import ReferenceEnv
    from reflexarc_sim_bridge.reference_field import FieldScore, measure, reference_contract
    from reflexarc_sim_bridge.seeds import test_seeds, training_seeds, validation_seeds
    from reflexarc_sim_bridge.simple_policies import BlindPolicy, RandomPolicy
    from reflexarc_sim_bridge.simulation import Simulation
    from reflexarc_sim_bridge.worlds import WORLDS, Discs, Edges, Rectangles, World, world_named

__all__ = [
    "WORLDS",
    "BlindPolicy",
    "Discs",
    "Edges",
    "FieldScore",
    "RandomPolicy",
    "Rectangles",
    "ReferenceEnv",
    "Simulation",
    "World",
    "measure",
    "reference_contract",
    "test_seeds",
    "training_seeds",
    "validation_seeds",
    "world_named",
]

_MODULE_OF = {
    "ReferenceEnv": "environment",
    **dict.fromkeys(("FieldScore", "measure", "reference_contract"), "reference_field"),
    **dict.fromkeys(("test_seeds", "training_seeds", "validation_seeds"), "seeds"),
    **dict.fromkeys(("BlindPolicy", "RandomPolicy"), "simple_policies"),
    "Simulation": "simulation",
    **dict.fromkeys(("WORLDS", "Discs", "Edges", "Rectangles", "World", "world_named"), "worlds"),
}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
