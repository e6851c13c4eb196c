"""reflexarc: a learned reflex for robots.

The public names, each loaded from its room only when it is used: importing this package costs
nothing, and a target without torch can use everything that needs none.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from reflexarc_sim_bridge.registration import announce

if TYPE_CHECKING:
    from reflexarc_logs.reader import read_log
    from reflexarc_logs.replay import replay
    from reflexarc_runtime.contract import PolicyContract, RetinaSpec
    from reflexarc_runtime.errors import ReflexarcError
    from reflexarc_runtime.policy import Policy, load_policy
    from reflexarc_sim_bridge.environment import ReferenceEnv
    from reflexarc_sim_bridge.reference_field import measure
    from reflexarc_sim_bridge.vector_environment import ReferenceVectorEnv
    from reflexarc_sim_bridge.world_files import world_named
    from reflexarc_trainer.export import export
    from reflexarc_trainer.presets import preset_named
    from reflexarc_trainer.train import train

_HOMES = {
    "Policy": "reflexarc_runtime.policy",
    "PolicyContract": "reflexarc_runtime.contract",
    "ReferenceEnv": "reflexarc_sim_bridge.environment",
    "ReferenceVectorEnv": "reflexarc_sim_bridge.vector_environment",
    "ReflexarcError": "reflexarc_runtime.errors",
    "RetinaSpec": "reflexarc_runtime.contract",
    "export": "reflexarc_trainer.export",
    "load_policy": "reflexarc_runtime.policy",
    "measure": "reflexarc_sim_bridge.reference_field",
    "preset_named": "reflexarc_trainer.presets",
    "read_log": "reflexarc_logs.reader",
    "replay": "reflexarc_logs.replay",
    "train": "reflexarc_trainer.train",
    "world_named": "reflexarc_sim_bridge.world_files",
}

__all__ = [
    "Policy",
    "PolicyContract",
    "ReferenceEnv",
    "ReferenceVectorEnv",
    "ReflexarcError",
    "RetinaSpec",
    "export",
    "load_policy",
    "measure",
    "preset_named",
    "read_log",
    "replay",
    "train",
    "world_named",
]

announce()  # Gymnasium knows the worlds by name from now on


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("reflexarc")
    if name not in _HOMES:
        raise AttributeError(f"module 'reflexarc' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
