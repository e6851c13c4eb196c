"""Whose contract a body follows, with a runtime that answers, does not, or says anything."""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, cast

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.following import Following
from support.processes import wait_until

A, B, C = b"a" * 16, b"b" * 16, b"c" * 16
FIVE = PolicyContract()
NINE = PolicyContract(retina=RetinaSpec(range_m=9.0))


@dataclass
class Built:
    """Stands for a body."""

    contract: PolicyContract


@dataclass
class Runtimes:
    """What each runtime answers, and who was asked."""

    contracts: dict[bytes, Any]
    asked: list[bytes] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    may_answer: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        self.may_answer.set()

    def ask(self, holder: bytes) -> PolicyContract | None:
        self.asked.append(holder)
        self.may_answer.wait(10.0)
        answer = self.contracts.get(holder)
        if isinstance(answer, Exception):
            raise answer
        return cast("PolicyContract | None", answer)

    def build(self, contract: PolicyContract) -> Body:
        if contract.retina.range_m == 3.0:
            raise WorldError("cannot be built")
        return cast("Body", Built(contract))


@contextmanager
def following(runtimes: Runtimes) -> Iterator[Following]:
    """A body that was built for runtime A."""
    with Following(runtimes.ask, runtimes.build, FIVE, A, runtimes.said.append) as it:
        yield it
    assert "following" not in [thread.name for thread in threading.enumerate()]


def settles(it: Following, holder: bytes) -> Body | None:
    """Ask as a loop does until the holder is known; the body that was built, if any was."""
    taken: list[Body] = []

    def is_settled() -> bool:
        is_open = it.is_open(holder)
        body = it.successor(holder)
        taken.extend([body] if body is not None else [])
        return not is_open

    wait_until(is_settled, "an end of the question", 10.0)
    assert len(taken) <= 1
    return taken[0] if taken else None


def test_nobody_and_the_runtime_that_it_was_built_for_are_not_asked():
    runtimes = Runtimes({A: NINE})
    with following(runtimes) as it:
        for _ in range(5):
            assert not it.is_open(b"")
            assert not it.is_open(A)
    assert runtimes.asked == []


def test_another_eye_builds_a_body_and_the_loop_stands_until_it_has_it():
    runtimes = Runtimes({B: NINE})
    runtimes.may_answer.clear()
    with following(runtimes) as it:
        assert it.is_open(B)
        wait_until(lambda: runtimes.asked == [B], "a question", 10.0)
        assert it.is_open(B)
        assert it.successor(B) is None
        runtimes.may_answer.set()
        assert settles(it, B) == Built(NINE)
    assert "range_m=9" in runtimes.said[0]


def test_what_makes_no_other_body_builds_none():
    same = replace(FIVE, provenance=Provenance(seed=9), margin=0.5, recovery_inputs=9)
    frames = replace(FIVE, retina=replace(FIVE.retina, frames=4))
    runtimes = Runtimes({B: same, C: frames})
    with following(runtimes) as it:
        assert settles(it, B) is None
        assert settles(it, C) is None
    assert runtimes.said == []


def test_what_makes_another_body_builds_one():
    others = {
        b"1" * 16: replace(FIVE, max_input_age_s=0.2),
        b"2" * 16: replace(FIVE, rate_hz=20.0),
        b"3" * 16: replace(FIVE, actions=FIVE.actions[:2]),
        b"4" * 16: replace(FIVE, retina=replace(FIVE.retina, fov_rad=math.pi / 2)),
    }
    with following(Runtimes(dict(others))) as it:
        for sender, contract in others.items():
            assert settles(it, sender) == Built(contract)


def test_who_does_not_answer_is_obeyed_as_it_is_and_asked_again():
    runtimes = Runtimes({})
    with following(runtimes) as it:
        assert settles(it, B) is None
        runtimes.contracts[B] = NINE
        wait_until(lambda: not it.is_open(B) and it.successor(B) is not None, "a body", 10.0)
        assert not it.is_open(B)


def test_whatever_is_raised_is_said_once_and_changes_nothing():
    runtimes = Runtimes({B: ValueError("broken"), C: replace(FIVE, retina=RetinaSpec(range_m=3.0))})
    with following(runtimes) as it:
        assert settles(it, B) is None
        assert settles(it, C) is None
        assert not it.is_open(C)
    assert [line.split(": ", 1)[1] for line in runtimes.said] == ["broken", "cannot be built"]


def test_back_and_forth_between_two_builds_each_time_and_ends_right():
    runtimes = Runtimes({A: FIVE, B: NINE})
    with following(runtimes) as it:
        for _ in range(3):
            assert settles(it, B) == Built(NINE)
            assert settles(it, A) == Built(FIVE)


def test_a_body_that_comes_too_late_is_not_taken_by_the_next_holder():
    runtimes = Runtimes({B: NINE, C: FIVE})
    runtimes.may_answer.clear()
    with following(runtimes) as it:
        assert it.is_open(B)
        wait_until(lambda: runtimes.asked == [B], "a question", 10.0)
        assert it.is_open(C)  # B has gone meanwhile
        runtimes.may_answer.set()
        assert settles(it, C) is None  # and C wants the eye that there still is
