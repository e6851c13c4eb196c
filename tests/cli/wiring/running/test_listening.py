"""When a loop begins to listen."""

import socket
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from reflexarc.main import main
from reflexarc.wiring.running import sense_act_loop
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.topics import Topic
from support.policies import exported


def test_senses_are_heard_once_nothing_else_is_to_be_done_and_people_before(
    tmp_path: Path, monkeypatch
):
    """A start that takes a moment must not look like a sender that is behind."""
    (tmp_path / "policy.onnx").write_bytes(exported(PolicyContract()))
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
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    words = ["run", tmp_path / "policy.onnx", "--no-guard", "--ticks", 1, "--port", port]
    assert main(list(map(str, words))) == 0
    assert order[-1] == "retina"
    assert order.index("stop") < order.index("warm") < order.index("retina")
