"""`reflexarc swap`: another policy for a loop that is running."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from reflexarc.commands.drive.operate import Speaking
from reflexarc.terminal.output import aside, console, plain, print_json
from reflexarc_runtime.errors import PolicyError

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.messages_pb2 import SwapAnswer

TRIED_WITHIN_S = 75.0
"""How long a runtime may take to try a policy, on a slow or busy machine, and to answer."""


@dataclass(frozen=True)
class SwapCommand:
    """Let another policy decide in a loop that is running, from its next standstill on.

    The file is tried here first, and then by the runtime, which believes nothing: in a process of
    its own, while the loop goes on. The policy must fit the running one: the same eye, body, rate,
    safe command, names of actions and size of memory. Should it fail, the former one decides the
    same tick. The runtime must have been started with --allow-swap. The signature beside the file,
    POLICY.onnx.sig, is sent along, for a runtime with --require-signature. Ends with 0 when the
    policy decides, with 1 if it is refused, still waits for standstill, or was rolled back.

    Examples:
      reflexarc swap runs/reflex-1/policy.onnx
      reflexarc swap runs/reflex-1/policy.onnx --robot rover1 --patience 30
      reflexarc swap runs/reflex-1/policy.onnx --while-moving --reason "the slow one"
    """

    policy: tyro.conf.Positional[Path]
    """The exported policy (ONNX), at most 1 MB."""
    while_moving: bool = False
    """Take over at the next tick, whatever the body does."""
    reason: str = "reflexarc swap"
    """Why; the log repeats it."""
    backend: Literal["numpy", "onnxruntime"] = "numpy"
    """What computes it here, when it is tried; the runtime uses its own."""
    speaking: Speaking = field(default_factory=Speaking)

    def run(self) -> int:
        """Try the file, ask the runtime, and say what it answered."""
        signature, data = self._signature(), self._tried()
        with self.speaking.bus() as bus:
            self._await_runtime(bus)
            self._check_fits(bus, data)
            answers = self._ask(bus, data, signature)
        return self._tell(answers)

    def _tried(self) -> bytes:
        """The bytes of the file, which a process of its own has tried.

        Raises:
            PolicyError: it is too large, or not intact.
        """
        from reflexarc_runtime.loop.candidates.swap_desk import check_size
        from reflexarc_runtime.loop.trials.trial import Trial
        from reflexarc_runtime.policy.model_file import policy_hash, read_model

        data = read_model(self.policy)
        try:
            check_size(data)
        except PolicyError as error:
            raise PolicyError(f"{self.policy}: {error}") from None
        with Trial(self.policy, self.backend) as trial:
            finding = trial.finding()
        if finding.policy_hash != policy_hash(data):
            raise PolicyError(f"{self.policy}: it changed while it was tried; try again")
        return data

    def _signature(self) -> bytes:
        """What lies beside the file, for a runtime that asks for it; empty: nothing does."""
        from reflexarc_runtime.policy.acceptance import signature_beside

        return signature_beside(self.policy)

    def _await_runtime(self, bus: "Bus") -> None:
        """Wait until a runtime is seen; this session has just joined."""
        import time

        from reflexarc_runtime.messages.topics import RUNTIME_NODE

        end_s = time.monotonic() + self.speaking.patience
        while not bus.is_alive(RUNTIME_NODE) and time.monotonic() < end_s:
            time.sleep(0.05)

    def _check_fits(self, bus: "Bus", data: bytes) -> None:
        """Compare it with the policy that runs, if the runtime says which one that is."""
        from reflexarc_runtime.contract.swap_fit import check_takes_over
        from reflexarc_runtime.loop.trials.contract_trial import tried_contract

        running = bus.fetch_policy(self.speaking.patience)
        if running is not None:
            theirs = tried_contract(running, bounds=None)
            check_takes_over(tried_contract(data, bounds=None), theirs)

    def _ask(self, bus: "Bus", data: bytes, signature: bytes) -> "list[SwapAnswer]":
        from google.protobuf.message import DecodeError

        from reflexarc_runtime.messages_pb2 import SwapAnswer, SwapRequest

        request = SwapRequest(
            policy=data,
            signature=signature,
            reason=self.reason,
            while_moving=self.while_moving,
            patience_s=self.speaking.patience,
        ).SerializeToString()
        found = []
        for said in bus.request_swap(request, TRIED_WITHIN_S + self.speaking.patience):
            try:
                found.append(SwapAnswer.FromString(said))
            except DecodeError:  # anybody can answer
                continue
        return found

    def _tell(self, answers: "list[SwapAnswer]") -> int:
        from reflexarc_runtime.messages_pb2 import SwapAnswer

        robot, is_done = self.speaking.joining.robot, bool(answers)
        for answer in answers:
            is_taken = answer.outcome == SwapAnswer.TAKEN
            is_done = is_done and is_taken
            if not self.speaking.json:
                say = console if is_taken else aside
                who = robot if is_taken else f"reflexarc swap: {robot}"
                say.print(f"{who}: {_words(answer)}", soft_wrap=True)
        if self.speaking.json:
            print_json({"done": is_done, "answers": [_plain(answer) for answer in answers]})
        if not answers:
            aside.print(f"reflexarc swap: no runtime of {robot} answered", soft_wrap=True)
        return 0 if is_done else 1


def _words(answer: "SwapAnswer") -> str:
    name = f"{answer.policy_hash[:12]}: " if answer.policy_hash else ""
    return f"{name}{plain(answer.words)}"


def _plain(answer: "SwapAnswer") -> dict[str, object]:
    from reflexarc_runtime.messages_pb2 import SwapAnswer

    known = {number: name for name, number in SwapAnswer.Outcome.items()}
    name = known.get(answer.outcome, "unknown")  # a younger runtime's, or anybody's
    return {
        "outcome": name.lower(),
        "words": answer.words,
        "policy_hash": answer.policy_hash,
        "tick": answer.tick,
    }
