"""The environments' names, one for each world, known to Gymnasium once reflexarc is imported.

World `reference-1` is `reflexarc/Reference-v1`, `corridor-10` is `reflexarc/Corridor10-v1`.
Gymnasium looks up no entry points, and a robot that imports reflexarc must not load Gymnasium. So
`announce` registers at once where Gymnasium is there already, and otherwise as soon as somebody
imports it.
"""

import contextlib
import importlib.util
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

REFERENCE_ID = "reflexarc/Reference-v1"

EPISODE_STEPS = 1000

_GYMNASIUM = "gymnasium"


def environment_id(world_name: str) -> str:
    """Name of the environment of a world. Only the reference's number is a version."""
    words = world_name.split("-")
    version = words.pop() if words[0] == "reference" else "1"
    return f"reflexarc/{''.join(map(str.capitalize, words))}-v{version}"


def register_environments() -> None:
    """Tell Gymnasium every world's environment. Nothing of ours is loaded until one is made."""
    import gymnasium

    from reflexarc_sim_bridge.worlds.files import WORLDS

    for name in WORLDS:
        if environment_id(name) not in gymnasium.registry:
            gymnasium.register(
                environment_id(name),
                entry_point="reflexarc_sim_bridge.environments.single:ReferenceEnv",
                vector_entry_point="reflexarc_sim_bridge.environments.vector:ReferenceVectorEnv",
                max_episode_steps=EPISODE_STEPS,
                kwargs={"world": name},
            )


def announce() -> None:
    """Register now if Gymnasium is loaded, else when it is."""
    if _GYMNASIUM in sys.modules:
        register_environments()
    elif not any(isinstance(finder, _WaitForGymnasium) for finder in sys.meta_path):
        sys.meta_path.insert(0, _WaitForGymnasium())


class _WaitForGymnasium(MetaPathFinder):
    """Sees the first import of Gymnasium, leaves it to the ordinary finders, then registers."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if name != _GYMNASIUM:
            return None
        with contextlib.suppress(ValueError):
            sys.meta_path.remove(self)
        spec = importlib.util.find_spec(_GYMNASIUM)
        if spec is not None and spec.loader is not None:
            _register_after(spec.loader)
        return spec


def _register_after(loader: Any) -> None:
    """Have this one loader register once it has run its module."""
    execute = loader.exec_module

    def exec_module(module: ModuleType) -> None:
        del loader.exec_module
        execute(module)
        register_environments()

    loader.exec_module = exec_module
