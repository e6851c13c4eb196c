"""Takes requests for another policy while the loop goes on, believes nothing, and answers in words.

What a request holds is tried in a process of its own: it may hang, break, or want all memory. What
fits is loaded, and put into the loop's inbox as a `Swap`, so that it is in the log and replays; the
controller decides when it takes over. One request is dealt with at a time.
"""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.swap_fit import check_takes_over
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.errors import PolicyError, ReflexarcError
from reflexarc_runtime.loop.candidates.swap_answers import Awaited, answer_in, refusal_in
from reflexarc_runtime.loop.candidates.take_overs import ServedSince, TakeOverCount, TakeOvers
from reflexarc_runtime.loop.candidates.trial_helper import Tries
from reflexarc_runtime.loop.trials.trial import check_fits
from reflexarc_runtime.loop.trials.tried_policy import finding_of
from reflexarc_runtime.loop.warm_up import decide_on_darkness
from reflexarc_runtime.messages.controls import encode_swap
from reflexarc_runtime.messages.topics import SWAP
from reflexarc_runtime.messages.wire import NO_SENDER, Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_runtime.serving.swapping import controller_for

MAX_POLICY_BYTES = 1_000_000
"""Of a policy that is swapped; with all that stands around it, it is one message of the log."""
MOST_PATIENCE_S = 60.0
"""An answer comes within this time after the trial, whatever the loop does."""
SWAPPED_HERE = 4
"""Policies that are kept beside the first one: who serves, who did, who is to, and the new one."""

Answer = Callable[[bytes], None]


@dataclass(frozen=True)
class SwapRules:
    """What is asked of a policy that shall take over."""

    forbidden: str = ""
    """Why none may at all, in words; empty: it may."""
    backend: str = "numpy"
    bounds: Bounds = field(default_factory=Bounds)
    check: Callable[[PolicyContract], object] = lambda contract: None
    """Raises a `ReflexarcError` if its contract asks for too much in other respects."""
    accept: Callable[[bytes, bytes], str] = lambda policy, signature: ""
    """Why the bytes of a file with this signature are not accepted, in words; empty if they are.
    Asked before anything of the file is parsed."""


class SwapDesk:
    """Deals with requests for one loop.

    Args:
        first: the controller of the policy of the start.
        controllers: by hash, what the loop's `SwappingController` knows beside it; it is filled.
        rules: what is asked of a policy.
        tries: tries one, in a process of its own.
        put: takes the swap: the loop's inbox, and whoever else is to hear of it.
        keep: takes all policies that may serve beside the first one, by hash, before they do: a
            recorder attaches them to what it begins later.
        now_ns: the clock of the loop.
        robot: the robot's name.
        sender: the identifier of the loop.
    """

    def __init__(
        self,
        first: Controller,
        controllers: dict[str, Controller],
        rules: SwapRules,
        tries: Tries,
        put: Callable[[Message], None],
        *,
        keep: Callable[[Mapping[str, bytes]], None] = lambda policies: None,
        now_ns: Callable[[], int],
        robot: str,
        sender: bytes = NO_SENDER,
    ) -> None:
        self._first, self._controllers = first, controllers
        self._rules, self._tries = rules, tries
        self._put, self._keep, self._now_ns = put, keep, now_ns
        self._key, self._sender = SWAP.key(robot), sender
        self._busy = threading.Lock()
        self._swaps = 0
        self.serving = first.policy_hash
        """The hash of the policy that decided last."""
        self._former = self._put_last = ""
        self._served = TakeOverCount()
        self._asked: list[str] = []
        """Hashes of those who were asked for, the newest last."""
        self._awaited: Awaited | None = None

    @property
    def policy(self) -> LoadedPolicy | None:
        """Who serves; None: that is no policy of a file."""
        found = self._controllers.get(self.serving, self._first).policy
        return found if isinstance(found, LoadedPolicy) else None

    @property
    def served(self) -> TakeOvers:
        """Who took over since the start."""
        return self._served.so_far

    def ask(self, request: bytes, answer: Answer) -> None:
        """Deal with a request in a thread of its own; from any thread.

        Args:
            request: `reflexarc.SwapRequest`.
            answer: is called with `reflexarc.SwapAnswer`, once.
        """
        if not self._busy.acquire(blocking=False):
            answer(refusal_in("another policy is being tried; ask again when that is over"))
            return
        threading.Thread(
            target=self._deal_with, args=(request, answer), name="swap", daemon=True
        ).start()

    def saw(self, decision: Decision) -> None:
        """Take note of a tick; from the loop's thread."""
        if decision.policy_hash != self.serving:
            self._former, self.serving = self.serving, decision.policy_hash
            self._served.note(ServedSince(decision.policy_hash, decision.index))
        if self._awaited is not None:
            self._awaited.saw(decision)

    def end_decision(self) -> None:
        """End the decision that is going on, whoever makes it: see `LoadedPolicy`."""
        for controller in (self._first, *list(self._controllers.values())):
            if isinstance(controller.policy, LoadedPolicy):
                controller.policy.end_decision()

    def _deal_with(self, request: bytes, answer: Answer) -> None:
        awaited = None
        try:
            asked = self._read(request)
            awaited = self._offer(asked)
            said = awaited.answer
        except ReflexarcError as error:
            said = refusal_in(str(error))
        except Exception as error:  # the loop goes on, whatever somebody sent
            said = refusal_in(f"it cannot be tried here: {type(error).__name__}: {error}"[:400])
        finally:
            self._busy.release()
        if awaited is not None:
            patience_s = min(asked.patience_s, MOST_PATIENCE_S) if asked.patience_s > 0.0 else 0.0
            awaited.done.wait(patience_s)
            said = awaited.answer
        answer(said)

    def _offer(self, asked: pb.SwapRequest) -> Awaited:
        """Try a policy, and put it to the loop."""
        identity = policy_hash(asked.policy)
        awaited = Awaited(identity)
        if identity == self.serving:  # whoever else was to take over no longer shall
            awaited.end(answer_in(pb.SwapAnswer.TAKEN, "it serves already", identity))
        else:
            self._register(self._tried(asked.policy))
        before, self._awaited = self._awaited, awaited
        if before is not None and not before.done.is_set():
            before.end(refusal_in("another policy was asked for since"))
        self._say(asked, identity)
        return awaited

    def _read(self, request: bytes) -> pb.SwapRequest:
        if self._rules.forbidden:
            raise PolicyError(self._rules.forbidden)
        if len(request) > MAX_POLICY_BYTES + 4096:
            raise PolicyError(_too_large())
        try:
            asked = pb.SwapRequest.FromString(request)
        except DecodeError:
            raise PolicyError("expected a reflexarc.SwapRequest, got something else") from None
        check_size(asked.policy)
        refusal = self._rules.accept(asked.policy, asked.signature)
        if refusal:
            raise PolicyError(refusal)
        return asked

    def _tried(self, data: bytes) -> LoadedPolicy:
        """Load a policy after a process of its own has, and has reproduced its golden vectors."""
        rules, running = self._rules, self._first.contract
        finding = finding_of(data, "policy", lambda path: self._tries.finding(path, rules.backend))
        policy = load_policy(data, rules.backend, verify=False, bounds=rules.bounds)
        check_fits(finding, policy)
        check_takes_over(policy.contract, running)
        rules.check(policy.contract)
        return policy

    def _register(self, policy: LoadedPolicy) -> None:
        controller = controller_for(policy, self._first)
        decide_on_darkness(controller)
        known, identity = self._controllers, policy.policy_hash
        known.setdefault(identity, controller)  # the loop looks here: what stays is never away
        self._asked = [*(name for name in self._asked if name != identity), identity]
        spared = (identity, self.serving, self._former, self._put_last)
        others = [name for name in self._asked if name not in spared]
        for name in others[: max(0, len(known) - SWAPPED_HERE)]:
            del known[name]
        self._asked = [name for name in self._asked if name in known]
        self._keep({name: _file_of(one) for name, one in known.items()})

    def _say(self, asked: pb.SwapRequest, identity: str) -> None:
        payload = encode_swap(
            asked.policy, identity, asked.reason[:200], while_moving=asked.while_moving
        )
        now_ns = self._now_ns()
        stamp = pack_stamp(Stamp(self._swaps, now_ns, self._sender))
        self._swaps, self._put_last = self._swaps + 1, identity
        self._put(Message(self._key, payload, protobuf_encoding(SWAP.schema), stamp, now_ns))


def check_size(policy: bytes) -> None:
    """Check the size of a policy that shall be swapped.

    Raises:
        PolicyError: it is empty, or larger than 1 MB.
    """
    if len(policy) > MAX_POLICY_BYTES:
        raise PolicyError(_too_large())
    if not policy:
        raise PolicyError("expected the bytes of a policy file, got none")


def _file_of(controller: Controller) -> bytes:
    assert isinstance(controller.policy, LoadedPolicy)  # it was loaded here
    return controller.policy.data


def _too_large() -> str:
    return f"expected a policy of at most {MAX_POLICY_BYTES // 1000} kB, got a larger one"
