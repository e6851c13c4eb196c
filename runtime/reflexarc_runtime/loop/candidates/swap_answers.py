"""What a runtime answers to a request for another policy, and when it knows."""

import threading

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.serving.swapping import SHOWN


class Awaited:
    """A policy that was put to the loop, and what became of it."""

    def __init__(self, identity: str) -> None:
        self._identity = identity
        self.done = threading.Event()
        words = "it waits for standstill: `reflexarc stop`, or ask with --while-moving"
        self.answer = answer_in(pb.SwapAnswer.WAITING, words, identity)

    def saw(self, decision: Decision) -> None:
        """Take note of a tick."""
        if self.done.is_set():
            return
        if decision.policy_hash == self._identity:
            words, outcome = f"it decides since tick {decision.index}", pb.SwapAnswer.TAKEN
        elif f"policy {self._identity[:SHOWN]} failed" in decision.reason:
            words, outcome = decision.reason, pb.SwapAnswer.ROLLED_BACK
        else:
            return
        self.end(answer_in(outcome, words, self._identity, decision.index))

    def end(self, answer: bytes) -> None:
        """That is what became of it."""
        self.answer = answer
        self.done.set()


def refusal_in(words: str) -> bytes:
    """`reflexarc.SwapAnswer` of one that is refused."""
    return answer_in(pb.SwapAnswer.REFUSED, words)


def answer_in(
    outcome: "pb.SwapAnswer.Outcome", words: str, identity: str = "", tick: int = 0
) -> bytes:
    """`reflexarc.SwapAnswer`."""
    return pb.SwapAnswer(
        outcome=outcome, words=words[:1000], policy_hash=identity, tick=tick
    ).SerializeToString()
