"""How a command joins the bus."""

import pytest

from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import NoRouterError, UsageError


@pytest.mark.parametrize("lockstep", [True, False])
def test_messages_wait_for_a_busy_network_in_lockstep_only(
    lockstep: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("reflexarc_runtime.bus.Bus", lambda config, now_ns, sender: config)
    config = Joining().bus("runtime", lockstep=lockstep)
    assert config.waits is lockstep  # type: ignore[attr-defined]  # it is the configuration


def test_who_waits_for_a_router_says_so_until_it_is_asked_to_end(monkeypatch):
    def none(config: object, now_ns: object, sender: object) -> None:
        raise NoRouterError("no router")

    monkeypatch.setattr("reflexarc_runtime.bus.Bus", none)
    monkeypatch.setattr("reflexarc.wiring.bus_flags.ASK_AGAIN_S", 0.0)
    told: list[str] = []
    with pytest.raises(NoRouterError):
        Joining().bus_in_time("runtime", lambda: len(told) == 3, "who", waiting=told.append)
    assert told == ["no router"] * 3


@pytest.mark.parametrize("joining", [Joining(robot="a b"), Joining(port=0), Joining(port=65536)])
def test_a_name_or_a_port_is_refused_before_a_session_is_opened(joining: Joining) -> None:
    with pytest.raises(UsageError, match=r"--robot|--port"):
        joining.check()
