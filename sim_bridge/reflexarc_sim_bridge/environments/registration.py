"""The names by which Gymnasium makes the environments, one for each world.

World `reference-1` is `reflexarc/Reference-v1`, `corridor-10` is `reflexarc/Corridor10-v1`.
Gymnasium looks up no entry points: it knows the names once somebody has called
`register_environments`, as `import reflexarc.envs` does.
"""

import gymnasium

from reflexarc_sim_bridge.environments.episodes import EPISODE_STEPS
from reflexarc_sim_bridge.worlds.files import WORLDS

REFERENCE_ID = "reflexarc/Reference-v1"


def environment_id(world_name: str) -> str:
    """Name of the environment of a world. Only the reference's number is a version."""
    words = world_name.split("-")
    version = words.pop() if words[0] == "reference" else "1"
    return f"reflexarc/{''.join(map(str.capitalize, words))}-v{version}"


def register_environments() -> None:
    """Tell Gymnasium every world's environment; what is known already stays as it is.

    No world is read, and nothing compiled is loaded, until an environment is made.
    """
    for name in WORLDS:
        if environment_id(name) not in gymnasium.registry:
            gymnasium.register(
                environment_id(name),
                entry_point="reflexarc_sim_bridge.environments.single:ReferenceEnv",
                vector_entry_point="reflexarc_sim_bridge.environments.vector:ReferenceVectorEnv",
                max_episode_steps=EPISODE_STEPS,
                kwargs={"world": name},
            )
