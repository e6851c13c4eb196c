"""How a command joins the bus."""

import pytest

from reflexarc.wiring.bus_flags import Joining


@pytest.mark.parametrize("lockstep", [True, False])
def test_messages_wait_for_a_busy_network_in_lockstep_only(
    lockstep: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("reflexarc_runtime.bus.Bus", lambda config, now_ns, sender: config)
    config = Joining().bus("runtime", lockstep=lockstep)
    assert config.waits is lockstep  # type: ignore[attr-defined]  # it is the configuration
