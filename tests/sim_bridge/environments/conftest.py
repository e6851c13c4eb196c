import pytest

from reflexarc_sim_bridge.environments.registration import register_environments


@pytest.fixture(scope="session", autouse=True)
def names() -> None:
    """Gymnasium knows the environments by name."""
    register_environments()
