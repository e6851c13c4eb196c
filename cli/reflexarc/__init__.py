"""reflexarc: a learned reflex for robots.

The public names, each loaded from its room only when it is used: importing this package costs
nothing, and a target without torch can use everything that needs none. `import reflexarc.envs`
tells Gymnasium the names of the environments.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reflexarc_logs.reading.reader import read_log
    from reflexarc_logs.replaying.replay import replay
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_runtime.contract.eye import RetinaSpec
    from reflexarc_runtime.errors import ReflexarcError
    from reflexarc_runtime.policy.policy import Policy, load_policy
    from reflexarc_sim_bridge.environments.single import ReferenceEnv
    from reflexarc_sim_bridge.environments.vector import ReferenceVectorEnv
    from reflexarc_sim_bridge.evaluation.reference_field import measure
    from reflexarc_sim_bridge.evaluation.running.evaluate import evaluate
    from reflexarc_sim_bridge.worlds.files import world_named
    from reflexarc_trainer.config.presets import preset_named
    from reflexarc_trainer.policy.export import export
    from reflexarc_trainer.policy.sb3_export import export_sb3
    from reflexarc_trainer.run.train import train

_HOMES = {
    "Policy": "reflexarc_runtime.policy.policy",
    "PolicyContract": "reflexarc_runtime.contract.contract",
    "ReferenceEnv": "reflexarc_sim_bridge.environments.single",
    "ReferenceVectorEnv": "reflexarc_sim_bridge.environments.vector",
    "ReflexarcError": "reflexarc_runtime.errors",
    "RetinaSpec": "reflexarc_runtime.contract.eye",
    "evaluate": "reflexarc_sim_bridge.evaluation.running.evaluate",
    "export": "reflexarc_trainer.policy.export",
    "export_sb3": "reflexarc_trainer.policy.sb3_export",
    "load_policy": "reflexarc_runtime.policy.policy",
    "measure": "reflexarc_sim_bridge.evaluation.reference_field",
    "preset_named": "reflexarc_trainer.config.presets",
    "read_log": "reflexarc_logs.reading.reader",
    "replay": "reflexarc_logs.replaying.replay",
    "train": "reflexarc_trainer.run.train",
    "world_named": "reflexarc_sim_bridge.worlds.files",
}

__all__ = [
    "Policy",
    "PolicyContract",
    "ReferenceEnv",
    "ReferenceVectorEnv",
    "ReflexarcError",
    "RetinaSpec",
    "evaluate",
    "export",
    "export_sb3",
    "load_policy",
    "measure",
    "preset_named",
    "read_log",
    "replay",
    "train",
    "world_named",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("reflexarc")
    if name not in _HOMES:
        raise AttributeError(f"module 'reflexarc' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
