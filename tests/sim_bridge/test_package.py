import subprocess
import sys

import reflexarc_sim_bridge


def loaded_after(statement: str) -> set[str]:
    script = f"{statement}\nimport sys\nprint(*sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(result.stdout.split())


def test_importing_the_package_compiles_and_loads_nothing_heavy() -> None:
    loaded = loaded_after("import reflexarc_sim_bridge; reflexarc_sim_bridge.world_named")
    assert not loaded & {"numba", "gymnasium", "zenoh", "torch", "mcap"}


def test_the_simulator_loads_neither_bus_nor_torch() -> None:
    loaded = loaded_after("import reflexarc_sim_bridge; reflexarc_sim_bridge.ReferenceEnv")
    assert "numba" in loaded
    assert not loaded & {"zenoh", "torch", "mcap"}


def test_every_public_name_is_there() -> None:
    for name in reflexarc_sim_bridge.__all__:
        assert getattr(reflexarc_sim_bridge, name) is not None
