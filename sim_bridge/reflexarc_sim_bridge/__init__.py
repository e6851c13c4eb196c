"""The body: worlds, eyes, motion and environments. Nothing compiled is loaded until it is used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reflexarc_sim_bridge.environment import ReferenceEnv
    from reflexarc_sim_bridge.layers import Scatter
    from reflexarc_sim_bridge.reference_field import FieldScore, measure, reference_contract
    from reflexarc_sim_bridge.seeds import test_seeds, training_seeds, validation_seeds
    from reflexarc_sim_bridge.shapes import Discs, Rectangles
    from reflexarc_sim_bridge.simple_policies import BlindPolicy, RandomPolicy
    from reflexarc_sim_bridge.simulation import Simulation
    from reflexarc_sim_bridge.vector_environment import ReferenceVectorEnv
    from reflexarc_sim_bridge.world_files import WORLDS, WorldFamily, read_world, world_named
    from reflexarc_sim_bridge.worlds import Edges, World

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
    "ReferenceEnv": "environment",
    "ReferenceVectorEnv": "vector_environment",
    **dict.fromkeys(("FieldScore", "measure", "reference_contract"), "reference_field"),
    **dict.fromkeys(("test_seeds", "training_seeds", "validation_seeds"), "seeds"),
    **dict.fromkeys(("BlindPolicy", "RandomPolicy"), "simple_policies"),
    "Simulation": "simulation",
    **dict.fromkeys(("WORLDS", "WorldFamily", "read_world", "world_named"), "world_files"),
    **dict.fromkeys(("Edges", "World"), "worlds"),
    **dict.fromkeys(("Discs", "Rectangles"), "shapes"),
    "Scatter": "layers",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
