"""A policy that was asked ahead decides as one that is asked when it is its turn."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.asked_policy import attached_policy
from reflexarc_logs.replaying.loop_events import loop_events
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.replaying.runs import asked_ahead
from reflexarc_logs.replaying.runs.asked_ahead import AskedAhead
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported
from support.recordings import CONTRACT, drive, faults


class Counted:
    """A graph that counts how often it is asked, and about how many retinas."""

    name = "numpy"

    def __init__(self, graph) -> None:
        self.graph, self.asked = graph, []

    def run(self, retinas, memories):
        self.asked.append(len(retinas))
        return self.graph.run(retinas, memories)

    def end_run(self) -> None:
        self.graph.end_run()


def recorded(tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    drive(path, exported(CONTRACT), faults(300), 300)
    return path


def test_what_was_asked_ahead_has_the_same_bits(tmp_path: Path) -> None:
    log = read_log(recorded(tmp_path))
    policy = attached_policy(log)
    counted = Counted(policy.graph)
    ahead, events = asked_ahead.asked_ahead(replace(policy, graph=counted), loop_events(log))
    asked = 0
    for event in events:
        if isinstance(event, Tick) and event.decision.q_values:
            stack = np.frombuffer(event.decision.retina, np.uint8)
            retinas = stack.reshape(1, *policy.contract.retina.stack_shape)
            alone, together = policy.decide(retinas), ahead.decide(retinas)
            assert alone[0].tobytes() == together[0].tobytes()
            assert alone[1].tobytes() == together[1].tobytes()
            asked += 1
    assert asked > 200
    assert len(counted.asked) < 5
    assert sum(counted.asked) <= asked


def test_what_the_log_does_not_hold_is_asked_when_it_comes() -> None:
    policy = load_policy(exported(CONTRACT))
    counted = Counted(policy.graph)
    graph = AskedAhead(replace(policy, graph=counted))
    shape = policy.contract.retina.stack_shape
    known, other = np.zeros((1, *shape), np.uint8), np.full((1, *shape), 9, np.uint8)
    graph.ask([known.tobytes(), b"too short"])
    for retinas in (known, other):
        assert graph.run(retinas, None)[0].tobytes() == policy.graph.run(retinas, None)[0].tobytes()
    assert counted.asked == [1, 1]


def test_level_node_finds_the_same_when_every_event_is_a_part(tmp_path: Path, monkeypatch) -> None:
    path, other = recorded(tmp_path), load_policy(exported(CONTRACT, seed=9))
    together = [str(replay(path, policy=policy).as_dict()) for policy in (None, other)]
    monkeypatch.setattr(asked_ahead, "EVENTS_AHEAD", 1)
    assert [str(replay(path, policy=policy).as_dict()) for policy in (None, other)] == together
