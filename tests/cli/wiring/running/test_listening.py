"""When a loop begins to listen, and when it says that it ends."""

import socket
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from reflexarc.main import main
from reflexarc.wiring.running import sense_act_loop
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.loop.loop_watchdog import LoopWatchdog
from reflexarc_runtime.messages.topics import Topic
from reflexarc_runtime.service import manager
from reflexarc_runtime.service.manager import NoManager
from support.policies import exported


def one_tick(folder: Path) -> int:
    """The status of a run of one tick, alone on its bus."""
    (folder / "policy.onnx").write_bytes(exported(PolicyContract()))
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    words = ["run", folder / "policy.onnx", "--no-guard", "--ticks", 1, "--port", port]
    return main(list(map(str, words)))


def test_a_manager_hears_of_the_end_before_anything_is_waited_for(tmp_path: Path, monkeypatch):
    """Nothing feeds its watchdog from then on, and threads may take seconds to end."""
    order: list[str] = []

    class Noting(NoManager):
        def ending(self) -> None:
            order.append("said")

    def ended(watchdog: LoopWatchdog, *why: Any) -> None:
        order.append("watchdog ends")
        leave(watchdog, *why)

    leave = LoopWatchdog.__exit__
    monkeypatch.setattr(LoopWatchdog, "__exit__", ended)
    monkeypatch.setattr(manager, "manager_of", Noting)
    assert one_tick(tmp_path) == 0
    assert order == ["said", "watchdog ends"]


def test_senses_are_heard_once_nothing_else_is_to_be_done_and_people_before(
    tmp_path: Path, monkeypatch
):
    """A start that takes a moment must not look like a sender that is behind."""
    order: list[str] = []
    subscribe, warm_up = Bus.subscribe, sense_act_loop.warm_up

    def noted(bus: Bus, topics: Sequence[Topic], *more: Callable[..., Any]) -> None:
        order.extend(topic.name for topic in topics)
        subscribe(bus, topics, *more)

    def warmed(controller: Any) -> None:
        order.append("warm")
        warm_up(controller)

    monkeypatch.setattr(Bus, "subscribe", noted)
    monkeypatch.setattr(sense_act_loop, "warm_up", warmed)
    assert one_tick(tmp_path) == 0
    assert order[-1] == "retina"
    assert order.index("stop") < order.index("warm") < order.index("retina")
