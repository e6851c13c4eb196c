"""The body: worlds, eyes, motion and environments. Nothing compiled is loaded until it is used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reflexarc_sim_bridge.environments.single import ReferenceEnv
    from reflexarc_sim_bridge.environments.vector import ReferenceVectorEnv
    from reflexarc_sim_bridge.evaluation.reference_field import FieldScore, measure
    from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
    from reflexarc_sim_bridge.simulation.simulation import Simulation
    from reflexarc_sim_bridge.worlds.files import WORLDS, WorldFamily, read_world, world_named
    from reflexarc_sim_bridge.worlds.layers import Scatter
    from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
    from reflexarc_sim_bridge.worlds.seeds import test_seeds, training_seeds, validation_seeds
    from reflexarc_sim_bridge.worlds.shapes import Discs, Rectangles
    from reflexarc_sim_bridge.worlds.world import Edges, World

__all__ = [
    "WORLDS",
    "BlindPolicy",
    "Discs",
    "Edges",
    "FieldScore",
    "RandomPolicy",
    "Rectangles",
    "ReferenceEnv",
    "ReferenceVectorEnv",
    "Scatter",
    "Simulation",
    "World",
    "WorldFamily",
    "measure",
    "read_world",
    "reference_contract",
    "test_seeds",
    "training_seeds",
    "validation_seeds",
    "world_named",
]

_MODULE_OF = {
    "ReferenceEnv": "environments.single",
    "ReferenceVectorEnv": "environments.vector",
    **dict.fromkeys(("FieldScore", "measure"), "evaluation.reference_field"),
    "reference_contract": "worlds.reference_contract",
    **dict.fromkeys(("test_seeds", "training_seeds", "validation_seeds"), "worlds.seeds"),
    **dict.fromkeys(("BlindPolicy", "RandomPolicy"), "evaluation.simple_policies"),
    "Simulation": "simulation.simulation",
    **dict.fromkeys(("WORLDS", "WorldFamily", "read_world", "world_named"), "worlds.files"),
    **dict.fromkeys(("Edges", "World"), "worlds.world"),
    **dict.fromkeys(("Discs", "Rectangles"), "worlds.shapes"),
    "Scatter": "worlds.layers",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
