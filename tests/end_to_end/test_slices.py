"""Ten real drives with faults: replay from each keyframe, and from any part of them."""

import random
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.cutting.cut import cut
from reflexarc_logs.cutting.span import TickSpan
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.asked_policy import attached_policy
from reflexarc_logs.replaying.beginning import begin, keep
from reflexarc_logs.replaying.comparison import EqualityRules
from reflexarc_logs.replaying.loop_events import LoopEvent, loop_events
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.replaying.stepping import Stepping
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.messages_pb2 import Keyframe, Tick
from support.policies import exported
from support.processes import finished, started
from support.slices import slice_by_time, times_ns

TICKS = 170
"""3.4 s: keyframes at 0, 1, 2 and 3 s."""
PLAIN = PolicyContract()
CONTRACTS = [
    PLAIN,
    replace(PLAIN, retina=replace(PLAIN.retina, frames=3)),
    replace(PLAIN, hold_s=0.1),
    replace(PLAIN, margin=0.2),
    replace(PLAIN, hold_s=0.3, margin=0.1, recovery_inputs=5),
]


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Twice five robots in one world, each with a runtime and a policy of its own."""
    folder = tmp_path_factory.mktemp("drives")
    return [log for fleet in range(2) for log in drive_five(folder, fleet)]


def drive_five(folder: Path, fleet: int) -> list[Path]:
    from socket import socket

    with socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    logs = [folder / f"{fleet}-{robot}.mcap" for robot in range(len(CONTRACTS))]
    with ExitStack() as stack:
        faults = ("--faults", f"seed:{fleet}")
        body = stack.enter_context(started("sim", "--robots", 5, "--port", port, *faults))
        runtimes = []
        for robot, (contract, log) in enumerate(zip(CONTRACTS, logs, strict=True)):
            policy = log.with_suffix(".onnx")
            policy.write_bytes(exported(contract, 10 * fleet + robot, "Relu"))
            words = ("--robot", f"robot{robot}", "--ticks", TICKS, "--record", log, "--json")
            runtimes.append(stack.enter_context(started("run", policy, "--port", port, *words)))
        for runtime in runtimes:
            finished(runtime)
        body.terminate()
    return logs


def decisions(log: Log, events: list[LoopEvent]) -> dict[int, bytes]:
    """What replay decides from the beginning of these events on, by tick."""
    policy = attached_policy(log)
    beginning, rest = begin(log, iter(events), policy)
    stepping = Stepping.at(beginning, policy, log, EqualityRules(exact=True, same_policy=True))
    found = {}
    for event in rest:
        if isinstance(event, Message):
            keep(stepping.waiting, event, log)
        elif isinstance(event, Tick):
            decision = stepping.step(event.decision)
            found[decision.index] = repr(decision).encode()
    return found


@pytest.mark.long
def test_from_every_keyframe_replay_is_the_tail_of_the_full_replay(logs):
    keyframes = 0
    for path in logs:
        log = read_log(path)
        events = list(loop_events(log))
        full = decisions(log, events)
        for at, event in enumerate(events):
            if isinstance(event, Keyframe):
                tail = {i: d for i, d in full.items() if i >= event.index}
                assert decisions(log, events[at:]) == tail
                keyframes += 1
        assert len(full) == TICKS + 1
    assert keyframes >= 4 * len(logs)


@pytest.mark.long
def test_a_hundred_random_parts_replay_at_both_levels(logs, tmp_path):
    dice = random.Random(17)
    for number in range(50):
        path = logs[number % len(logs)]
        first = dice.randrange(TICKS)
        end = dice.randrange(first + 1, TICKS + 2)
        part = cut(read_log(path), TickSpan(first, end), tmp_path / f"cut-{number}.mcap")
        check(part.path, at_least=end - first)
        earliest_ns, latest_ns = times_ns(path)
        begin_ns = dice.randrange(earliest_ns, earliest_ns + 1_500_000_000)
        end_ns = dice.randrange(begin_ns + 1_600_000_000, latest_ns + 1)
        check(slice_by_time(path, tmp_path / f"{number}.mcap", begin_ns, end_ns), at_least=20)


def check(path: Path, at_least: int) -> None:
    report = replay(path)
    assert report.exit_status == 0, report.lines()
    levels = {level.level: level for level in report.levels}
    assert levels["node"].compared >= at_least
    assert "policy" in levels
