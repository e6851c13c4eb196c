"""`reflexarc.envs`: the module whose import registers the environments, and nothing else does."""

import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from reflexarc_sim_bridge.environments.registration import environment_id
from reflexarc_sim_bridge.environments.single import ReferenceEnv
from reflexarc_sim_bridge.environments.vector import ReferenceVectorEnv
from reflexarc_sim_bridge.worlds.files import WORLDS

NAME = "reflexarc.envs:reflexarc/Reference-v1"


def run(script: str) -> str:
    command = [sys.executable, "-W", "error", "-c", script]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_gymnasium_makes_an_environment_by_module_and_name() -> None:
    environment = gymnasium.make(NAME)
    assert isinstance(environment.unwrapped, ReferenceEnv)
    environment.close()
    envs = gymnasium.make_vec(NAME, num_envs=2)
    assert isinstance(envs.unwrapped, ReferenceVectorEnv)
    envs.close()


@pytest.mark.parametrize("make", ["make", "make_vec"])
def test_a_fresh_process_needs_only_the_name(make: str) -> None:
    script = f"import gymnasium; print(type(gymnasium.{make}({NAME!r}).unwrapped).__name__)"
    assert run(script).strip() in ("ReferenceEnv", "ReferenceVectorEnv")


def test_importing_the_module_registers_every_world() -> None:
    script = """
import gymnasium, reflexarc.envs
print(*(name for name in gymnasium.registry if name.startswith("reflexarc/")))
"""
    assert run(script).split() == [environment_id(name) for name in WORLDS]


def test_registering_loads_nothing_compiled() -> None:
    script = "import sys, reflexarc.envs; print({'numba', 'torch', 'zenoh'} & set(sys.modules))"
    assert run(script).strip() == "set()"


@pytest.mark.parametrize(
    "module", ["reflexarc", "reflexarc_sim_bridge", "reflexarc_sim_bridge.environments"]
)
def test_no_other_import_registers_or_loads_gymnasium(module: str) -> None:
    script = f"""
import sys, {module}
print("gymnasium" in sys.modules)
import gymnasium
print(sum(name.startswith("reflexarc/") for name in gymnasium.registry))
"""
    assert run(script).split() == ["False", "0"]


def test_the_class_alone_registers_nothing() -> None:
    script = """
import gymnasium, reflexarc
reflexarc.ReferenceEnv, reflexarc.ReferenceVectorEnv
print(sum(name.startswith("reflexarc/") for name in gymnasium.registry))
"""
    assert run(script).strip() == "0"


ASYNCHRONOUS = f"""
import gymnasium
from functools import partial
from gymnasium.vector import AsyncVectorEnv

if __name__ == "__main__":
    make = partial(gymnasium.make, {NAME!r})
    for envs in (
        AsyncVectorEnv([make, make], context="spawn"),
        gymnasium.make_vec(
            {NAME!r}, 2, vectorization_mode="async", vector_kwargs={{"context": "spawn"}}
        ),
    ):
        print(*envs.reset(seed=3)[0].ravel())
        envs.close()
"""


def test_spawned_processes_make_it_by_the_same_name(tmp_path: Path) -> None:
    script = tmp_path / "asynchronous.py"
    script.write_text(ASYNCHRONOUS)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    expected, _ = ReferenceVectorEnv(2).reset(seed=3)
    for line in done.stdout.splitlines():
        assert np.array_equal(np.array(line.split(), np.uint8), expected.ravel())
    assert len(done.stdout.splitlines()) == 2


@pytest.mark.parametrize("package", ["gymnasium", "numba"])
def test_without_the_extra_the_error_names_it_in_one_line(package: str) -> None:
    script = f"""
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name == {package!r} else find(name, *rest)
try:
    import reflexarc.envs
except ModuleNotFoundError as error:
    print(error)
"""
    assert run(script) == (
        f"reflexarc.envs: expected the package {package}, got none; "
        "install the extra: pip install 'reflexarc[sim]'\n"
    )
