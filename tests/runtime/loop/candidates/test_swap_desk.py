"""Requests for another policy: what is refused, in which words, and what reaches the loop."""

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.candidates.swap_desk import SWAPPED_HERE, SwapDesk, SwapRules
from reflexarc_runtime.loop.candidates.take_overs import MOST_REMEMBERED
from reflexarc_runtime.loop.candidates.trial_helper import TrialHelper
from reflexarc_runtime.loop.trials.trial import Finding
from reflexarc_runtime.messages.controls import swap_of
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, exported

QUICK_NS = 20_000


@dataclass
class Tries:
    """A trial that finds what it is told to."""

    decision_ns: int = QUICK_NS
    refuses: str = ""
    waits_for: threading.Event | None = None

    def finding(self, path: Path, backend: str) -> Finding:
        if self.waits_for is not None:
            assert self.waits_for.wait(10)
        if self.refuses:
            raise PolicyError(f"{path}: {self.refuses}")
        return Finding(policy_hash(path.read_bytes()), self.decision_ns)


@dataclass
class Office:
    """A desk, the loop that it speaks to, and what was answered."""

    rules: SwapRules = field(default_factory=SwapRules)
    tries: object = field(default_factory=Tries)
    put: list[Message] = field(default_factory=list)
    kept: list[Mapping[str, bytes]] = field(default_factory=list)
    answers: list[pb.SwapAnswer] = field(default_factory=list)
    known: Any = field(default_factory=dict)
    index: int = 0

    def __post_init__(self) -> None:
        policy = load_policy(exported(SMALL, seed=1))
        self.first = Controller(policy, SMALL, RetinaSense(SMALL.retina), policy.policy_hash)
        self.said = threading.Semaphore(0)
        self.desk = SwapDesk(
            self.first,
            self.known,
            self.rules,
            self.tries,  # type: ignore[arg-type]  # one of two that try
            self.take,
            keep=self.kept.append,
            now_ns=lambda: 7,
            robot="robot0",
        )
        self.reacts: Callable[[pb.Swap], None] = self.serves

    def take(self, message: Message) -> None:
        """What the loop does with a swap, at its next tick."""
        self.put.append(message)
        swap = swap_of(message)
        assert swap is not None
        self.reacts(swap)

    def serves(self, swap: pb.Swap) -> None:
        self.desk.saw(self.decision(swap.policy_hash))

    def decision(self, identity: str, reason: str = "") -> Decision:
        from reflexarc_runtime.decision import Verdict, safe_command

        self.index += 1
        command = safe_command(self.index, Verdict.STOPPED, SMALL.safe_command)
        return Decision(
            self.index, 0, 0, 0, None, b"", (), -1, -1, Verdict.STOPPED, reason, command, identity
        )

    def ask(self, policy: bytes, **more: object) -> pb.SwapAnswer:
        request = pb.SwapRequest(policy=policy, **more).SerializeToString()  # type: ignore[arg-type]
        return self.send(request)

    def send(self, request: bytes) -> pb.SwapAnswer:
        self.desk.ask(request, self.hear)
        assert self.said.acquire(timeout=20)
        return self.answers[-1]

    def hear(self, answer: bytes) -> None:
        self.answers.append(pb.SwapAnswer.FromString(answer))
        self.said.release()


def of(seed: int, **changes: object) -> bytes:
    return exported(replace(SMALL, **changes), seed=seed)  # type: ignore[arg-type]


def test_what_fits_reaches_the_loop_as_a_swap_and_is_known_before():
    office = Office()
    knew: list[bool] = []
    office.reacts = lambda swap: (
        knew.append(swap.policy_hash in office.known and swap.policy_hash in office.kept[-1]),
        office.serves(swap),
    )[1]
    policy = of(2)
    answer = office.ask(policy, reason="better", while_moving=True, patience_s=5.0)
    assert (answer.outcome, answer.words) == (pb.SwapAnswer.TAKEN, "it decides since tick 1")
    swap = swap_of(office.put[0])
    assert swap is not None
    assert (swap.policy, swap.policy_hash, swap.while_moving) == (policy, policy_hash(policy), True)
    assert knew == [True]
    assert office.desk.policy is not None
    assert office.desk.policy.data == policy
    assert [one.policy_hash for one in office.desk.served.last] == [policy_hash(policy)]


@pytest.mark.parametrize(
    ("policy", "words"),
    [
        (b"", "expected the bytes of a policy file, got none"),
        (bytes(1_000_001), "at most 1000 kB"),
        (of(2, rate_hz=40.0), "rate_hz: 50.0 → 40.0"),
        (of(2)[:-9], "policy"),
        (b"not a policy at all", "policy"),
    ],
)
def test_what_is_too_large_hostile_truncated_or_of_another_contract_is_refused(policy, words):
    office = Office()
    answer = office.ask(policy)
    assert (answer.outcome, office.put, office.known) == (pb.SwapAnswer.REFUSED, [], {})
    assert words in answer.words


def test_a_request_that_is_none_is_refused():
    assert "expected a reflexarc.SwapRequest" in Office().send(b"\xff\xff\xff").words


def test_without_leave_nothing_is_even_read():
    office = Office(SwapRules("start it with --allow-swap"))
    assert office.ask(of(2)).words == "start it with --allow-swap"


def test_a_policy_that_is_slow_refused_at_its_trial_or_not_accepted_does_not_reach_the_loop():
    slow = Office(tries=Tries(decision_ns=30_000_000)).ask(of(2))
    assert "expected a decision within 20 ms" in slow.words
    broken = Office(tries=Tries(refuses="it hangs")).ask(of(2))
    assert broken.words == "policy: it hangs"
    unsigned = Office(SwapRules(accept=lambda data, signature: "no signature")).ask(of(2))
    assert unsigned.words == "no signature"
    assert slow.outcome == broken.outcome == unsigned.outcome == pb.SwapAnswer.REFUSED


def test_its_signature_is_looked_at_before_anything_of_it_is_parsed():
    seen: list[tuple[bytes, bytes]] = []
    rules = SwapRules(accept=lambda data, signature: (seen.append((data, signature)), "no")[1])
    tries = Tries(refuses="it was parsed")
    answer = Office(rules, tries).ask(b"no policy at all", signature=b"signed")
    assert (answer.words, seen) == ("no", [(b"no policy at all", b"signed")])


def test_the_bounds_of_the_run_hold_for_it():
    from reflexarc_runtime.contract.bounds import Bounds
    from reflexarc_runtime.contract.motion import sideways_actions

    office = Office(SwapRules(bounds=Bounds(max_speed_mps=2.0)))
    assert "--max-speed-mps" in office.ask(of(2, actions=sideways_actions(3.0))).words


def test_it_says_that_it_waits_and_that_another_one_came_in_its_place():
    office = Office()
    office.reacts = lambda swap: None
    assert office.ask(of(2)).outcome == pb.SwapAnswer.WAITING
    waits = threading.Thread(target=office.ask, args=(of(3),), kwargs={"patience_s": 20.0})
    waits.start()
    while len(office.put) < 2:
        pass
    superseded, end_s = "another policy was asked for since", time.monotonic() + 20.0
    while superseded not in {one.words for one in office.answers} and time.monotonic() < end_s:
        office.desk.ask(pb.SwapRequest(policy=of(4)).SerializeToString(), office.hear)
        time.sleep(0.02)  # the desk may still be busy with the one before
    assert superseded in {one.words for one in office.answers}
    waits.join(20)


def test_one_request_is_dealt_with_at_a_time():
    gate = threading.Event()
    office = Office(tries=Tries(waits_for=gate))
    office.desk.ask(pb.SwapRequest(policy=of(2), patience_s=5).SerializeToString(), office.hear)
    refused = office.ask(of(3))
    assert refused.words == "another policy is being tried; ask again when that is over"
    gate.set()
    assert office.said.acquire(timeout=20)
    assert office.answers[-1].outcome == pb.SwapAnswer.TAKEN


def test_who_fails_at_once_was_rolled_back_and_who_serves_already_is_left_alone():
    office = Office()
    identity = policy_hash(of(2))[:12]
    words = f"policy {identity} failed (ValueError): rolled back to {office.first.policy_hash[:12]}"
    office.reacts = lambda swap: office.desk.saw(office.decision(office.first.policy_hash, words))
    answer = office.ask(of(2), patience_s=5.0)
    assert (answer.outcome, answer.words) == (pb.SwapAnswer.ROLLED_BACK, words)
    again = office.ask(of(1))
    assert (again.outcome, again.words) == (pb.SwapAnswer.TAKEN, "it serves already")


def test_only_a_few_are_kept_and_never_is_who_serves_or_did_forgotten():
    office = Office()
    office.ask(of(2), patience_s=5.0)
    office.ask(of(3), patience_s=5.0)
    office.reacts = lambda swap: None
    for seed in range(10, 20):
        office.ask(of(seed))
    assert len(office.known) <= SWAPPED_HERE
    assert {policy_hash(of(seed)) for seed in (2, 3, 18, 19)} <= set(office.known)
    assert set(office.kept[-1]) == set(office.known)


class Watched(dict[str, Controller]):
    """Remembers who was taken out, if only for a moment."""

    def __init__(self) -> None:
        self.taken_out: list[str] = []

    def pop(self, name: str, *other: Any) -> Any:
        self.taken_out += [name] * (name in self)
        return super().pop(name, *other)

    def __delitem__(self, name: str) -> None:
        self.taken_out.append(name)
        super().__delitem__(name)


def test_who_stays_is_never_away_while_the_loop_looks():
    office = Office(known=Watched())
    wanted = [policy_hash(of(seed)) for seed in (2, 3)]
    for seed in (2, 3, 2, 3, 4, 3):
        office.ask(of(seed), patience_s=5.0)
    first = office.known[wanted[0]]
    office.ask(of(2), patience_s=5.0)
    assert office.known[wanted[0]] is first  # the loop has seen it work
    assert office.known.taken_out == []
    for seed in range(10, 14):
        office.ask(of(seed), patience_s=5.0)
    assert office.known.taken_out[0] == policy_hash(of(4))  # asked for longest ago


def test_it_counts_all_who_took_over_and_remembers_the_last_ones():
    office = Office()
    names = [f"{number}" for number in range(150)]
    for name in names:
        office.desk.saw(office.decision(name))
    served = office.desk.served
    assert (served.count, len(served.last)) == (150, MOST_REMEMBERED)
    assert [one.policy_hash for one in served.last] == names[-MOST_REMEMBERED:]


def test_a_helper_tries_in_a_process_of_its_own_and_its_end_is_a_refusal(tmp_path: Path):
    with TrialHelper() as helper:
        office = Office(tries=helper)
        assert office.ask(of(2), patience_s=5.0).outcome == pb.SwapAnswer.TAKEN
        assert "policy" in office.ask(b"none").words
        helper.__exit__(None, None, None)
        assert "the process that tries policies" in office.ask(of(3)).words
