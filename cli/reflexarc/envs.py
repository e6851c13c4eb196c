"""Gymnasium environments of all worlds: importing this module registers their names.

    gymnasium.make("reflexarc.envs:reflexarc/Reference-v1")

Gymnasium imports what stands before the colon, in whichever process makes the environment. After
`import reflexarc.envs` the names are known without it: `gymnasium.make("reflexarc/Reference-v1")`.

Raises:
    ModuleNotFoundError: the extra `sim` is not installed.
"""

from importlib.util import find_spec

for _package in ("gymnasium", "numba"):
    if find_spec(_package) is None:
        raise ModuleNotFoundError(
            f"reflexarc.envs: expected the package {_package}, got none; "
            "install the extra: pip install 'reflexarc[sim]'",
            name=_package,
        )

from reflexarc_sim_bridge.environments.registration import (  # noqa: E402  # checked first
    register_environments,
)

register_environments()
