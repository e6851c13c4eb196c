"""Anybody may answer a body that asks for a policy."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from reflexarc.wiring.asking import Asking, Wanted
from reflexarc_runtime.bus import PolicyAnswer
from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.loop.trials import contract_trial
from support.policies import exported

A, B = b"a" * 16, b"b" * 16
NEAR = PolicyContract(retina=RetinaSpec(rays=4))
FAR = PolicyContract(retina=RetinaSpec(rays=4, range_m=9.0))
NEAR_FILE, FAR_FILE = exported(NEAR), exported(FAR)


@dataclass
class FakeBus:
    """Answers."""

    answers: list[PolicyAnswer] = field(default_factory=list)

    def policy_answers(self, timeout_s: float) -> Iterator[PolicyAnswer]:
        yield from self.answers


@pytest.fixture
def said() -> list[str]:
    return []


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Which files a process was started for."""
    files: list[bytes] = []
    really = contract_trial.tried_contract

    def count(data: bytes, bounds: Bounds) -> PolicyContract:
        files.append(data)
        return really(data, bounds)

    monkeypatch.setattr(contract_trial, "tried_contract", count)
    return files


def asking(said: list[str], *answers: tuple[bytes, bytes], check: Any = lambda c: None) -> Asking:
    bus: Any = FakeBus([PolicyAnswer(*answer) for answer in answers])
    return Asking(bus, Bounds(), said.append, check)


def test_the_first_that_can_be_used_is_taken_and_garbage_is_said_once(
    said: list[str], tried: list[bytes]
):
    it = asking(said, (B, b"garbage"), (A, NEAR_FILE))
    for _ in range(3):
        assert it.anybody() == Wanted(A, replace(NEAR, golden=GoldenVectors()))
    assert len(said) == 1
    assert "expected an ONNX model" in said[0]
    assert tried == [b"garbage", NEAR_FILE]


def test_only_who_was_asked_counts(said: list[str]):
    it = asking(said, (B, FAR_FILE), (A, NEAR_FILE))
    assert it.of(A) == replace(NEAR, golden=GoldenVectors())
    assert it.of(B) == replace(FAR, golden=GoldenVectors())
    assert it.of(b"c" * 16) is None
    assert said == []


def test_of_two_that_say_the_same_name_neither_is_believed(said: list[str]):
    it = asking(said, (A, NEAR_FILE), (A, FAR_FILE))
    assert it.of(A) is None
    assert it.of(A) is None
    assert len(said) == 1


def test_the_same_answer_twice_is_one(said: list[str]):
    assert asking(said, (A, NEAR_FILE), (A, NEAR_FILE)).of(A) is not None


def test_what_nothing_can_be_built_for_is_refused(said: list[str]):
    def check(contract: PolicyContract) -> None:
        if contract.retina.range_m == 9.0:
            raise WorldError("too far")

    it = asking(said, (A, FAR_FILE), (B, NEAR_FILE), check=check)
    wanted = it.anybody()
    assert wanted is not None
    assert wanted.sender == B
    assert "too far" in said[0]


def test_a_flood_of_garbage_fills_no_memory(said: list[str], monkeypatch: pytest.MonkeyPatch):
    def refuse(data: bytes, bounds: Bounds) -> PolicyContract:
        raise WorldError("none")

    monkeypatch.setattr(contract_trial, "tried_contract", refuse)
    it = asking(said, *((A, str(n).encode()) for n in range(1000)))
    assert it.anybody() is None
    assert len(it._known) <= 64
