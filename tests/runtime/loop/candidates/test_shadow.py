"""A policy that watches: what it says, and that nothing of what it does reaches the loop."""

import os
import signal
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Decision, Input, Verdict, safe_command
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.candidates.shadow import MOST_BEHIND, Shadow
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.serving.shadowing import ShadowMind, ShadowTick
from support.policies import SMALL, exported
from support.swapped_drives import fails_in_the_light

PATIENCE_S = 20.0


def asked(index: int, retina: bytes, winner: int = 0) -> Decision:
    """A tick at which the policy that decides preferred an action."""
    command = safe_command(index, Verdict.OK, SMALL.safe_command)
    used = Input(index, index, index, 0)
    return Decision(
        index, index, index, 1, used, retina, (0.0,), winner, winner, Verdict.OK, "", command, "old"
    )


def shadow_of(policy: bytes, put: Callable[[Message], None], **more: float) -> Shadow:
    return Shadow(policy, "numpy", put, robot="robot0", **more)


def retinas(count: int) -> list[bytes]:
    rng = np.random.default_rng(4)
    return [rng.integers(0, 255, 4, np.uint8).tobytes() for _ in range(count)]


def test_it_says_what_its_policy_prefers_by_how_much_and_how_often_that_is_something_else():
    policy, said = exported(SMALL, seed=3), list[Message]()
    with shadow_of(policy, said.append, patience_s=PATIENCE_S) as shadow:
        for index, retina in enumerate(retinas(30)):
            shadow.saw(asked(index, retina, winner=1))
    words = [pb.Shadow.FromString(message.payload) for message in said]
    loaded = load_policy(policy)
    for index, (retina, word) in enumerate(zip(retinas(30), words, strict=True)):
        stack = np.frombuffer(retina, np.uint8).reshape(1, *SMALL.retina.stack_shape)
        q_values, winners = loaded.decide(stack)
        assert (word.index, word.drove, word.winner) == (index, 1, winners[0])
        assert list(word.q_values) == q_values[0].tolist()
        assert word.lead == pytest.approx(q_values[0].max() - q_values[0][1])
    different = sum(word.winner != 1 for word in words)
    account = shadow.account
    assert (account.compared, account.different, account.lost) == (30, different, 0)
    assert said[0].key == "robot0/shadow"
    assert [word.begins for word in words] == [True] + [False] * 29


def test_one_that_hangs_misses_ticks_and_holds_nobody_up():
    """The process is stopped: it neither reads nor answers."""
    said: list[Message] = []
    with shadow_of(exported(SMALL, seed=3), said.append) as shadow:
        os.kill(shadow.pid, signal.SIGSTOP)
        for index, retina in enumerate(retinas(100)):
            shadow.saw(asked(index, retina))
        account = shadow.account
        assert (account.given, account.lost, account.compared) == (MOST_BEHIND, 92, 0)
        os.kill(shadow.pid, signal.SIGCONT)
        end_s = time.monotonic() + PATIENCE_S
        while account.compared < MOST_BEHIND and time.monotonic() < end_s:
            shadow.saw(replace(asked(200, b""), retina=b""))
        shadow.saw(asked(201, retinas(1)[0]))
    assert [pb.Shadow.FromString(one.payload).index for one in said] == [*range(8), 201]
    assert pb.Shadow.FromString(said[-1].payload).begins


def test_in_lockstep_one_that_hangs_is_waited_for_only_for_what_it_was_given(
    monkeypatch: pytest.MonkeyPatch,
):
    waited: list[float] = []
    with shadow_of(exported(SMALL, seed=3), lambda message: None, patience_s=5.0) as shadow:
        monkeypatch.setattr(shadow, "_waited", lambda seconds: bool(waited.append(seconds)))
        os.kill(shadow.pid, signal.SIGSTOP)
        for index, retina in enumerate(retinas(100)):
            shadow.saw(asked(index, retina))
        assert shadow.account.lost == 100 - MOST_BEHIND
        os.kill(shadow.pid, signal.SIGKILL)
    assert waited[:MOST_BEHIND] == [5.0] * MOST_BEHIND
    assert 5.0 not in waited[MOST_BEHIND:]


def test_one_that_ends_is_counted_as_ended_and_every_tick_as_missed():
    with shadow_of(exported(SMALL, seed=3), lambda message: None) as shadow:
        os.kill(shadow.pid, signal.SIGKILL)
        end_s, index = time.monotonic() + PATIENCE_S, 0
        while not shadow.account.has_ended and time.monotonic() < end_s:
            shadow.saw(asked(index, retinas(1)[0]))
            index += 1
        shadow.saw(asked(index, retinas(1)[0]))
        assert shadow.account.has_ended
        assert shadow.account.lost == index + 1
        assert "has ended" in shadow.state


def test_one_that_gives_no_numbers_is_counted_as_faulty_and_goes_on():
    policy, said = fails_in_the_light(SMALL), list[Message]()
    with shadow_of(policy, said.append, patience_s=PATIENCE_S) as shadow:
        for index, brightness in enumerate([10, 250, 10]):
            shadow.saw(asked(index, bytes([brightness] * 4)))
    words = [pb.Shadow.FromString(message.payload) for message in said]
    assert [word.fault for word in words] == ["", "values not finite, or no such action", ""]
    assert (shadow.account.compared, shadow.account.faults) == (3, 1)


def test_a_file_that_does_not_load_is_refused():
    with pytest.raises(PolicyError, match="--shadow"):
        shadow_of(b"none", lambda message: None).__enter__()


def test_its_process_ends_with_it():
    with shadow_of(exported(SMALL, seed=3), lambda message: None) as shadow:
        pid = shadow.pid
        os.kill(pid, signal.SIGSTOP)
    assert not Path(f"/proc/{pid}").exists()


def test_what_it_remembers_begins_anew_where_it_missed_a_tick_and_after_a_fault():
    from support.remembering import REMEMBERING, remembering_policy

    policy = load_policy(remembering_policy(1))
    pixels = np.random.default_rng(1).integers(0, 255, REMEMBERING.retina.size, np.uint8).tobytes()
    mind = ShadowMind(policy)
    first = mind.decide(ShadowTick(0, 0, pixels, 0, True, True))
    second = mind.decide(ShadowTick(1, 1, pixels, 0, False, True))
    again = mind.decide(ShadowTick(5, 5, pixels, 0, True, True))
    assert list(first.q_values) != list(second.q_values)
    assert list(first.q_values) == list(again.q_values)
    same_input = mind.decide(ShadowTick(6, 6, pixels, 0, False, False))
    assert list(same_input.q_values) == list(first.q_values)
