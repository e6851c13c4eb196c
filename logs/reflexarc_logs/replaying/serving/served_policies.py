"""The policies that a log holds beside the first one: those that took over, and those that watched.

A swap in the log holds its policy; of what took over before a part or a slice begins, and of what
watched, the file is attached. They are looked for when somebody names one that is not known yet:
nearly all logs have one policy. What counts is the hash of the bytes, whatever a log calls them.
"""

from collections.abc import Iterator, Mapping

from reflexarc_logs.container.writing import ATTACHED_BESIDE
from reflexarc_logs.reading.reader import Log, decode
from reflexarc_logs.reading.record import Record
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.errors import LogError, ReflexarcError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.messages.topics import SWAP
from reflexarc_runtime.messages_pb2 import Swap
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.serving.swapping import controller_for

KEPT_BYTES = 64 << 20
"""Of files that were found while another one was looked for."""


class ServedPolicies:
    """Who decided on a log, by hash.

    Args:
        log: the log.
        policy: whom to ask: the log's own first policy; or a candidate, which decides all ticks.
    """

    def __init__(self, log: Log, policy: LoadedPolicy) -> None:
        self._log, self.first = log, policy
        named = log.run.policy_hash
        self.are_followed = policy.policy_hash == named
        """Whether each tick is decided by the policy that decided it, and not by a candidate."""
        self._found: dict[str, bytes] = {}
        self._found_bytes = 0
        self._absent: set[str] = set()
        self._loaded = {policy.policy_hash: policy}

    def of(self, identity: str) -> LoadedPolicy | None:
        """The policy that decides where the log names this one; None: the log does not hold it.

        Raises:
            PolicyError, ContractError: it is not intact.
        """
        if not self.are_followed or not identity:
            return self.first
        return self.named(identity)

    def named(self, identity: str) -> LoadedPolicy | None:
        """The policy of this hash; None: the log does not hold it.

        Raises:
            PolicyError, ContractError: it is not intact.
        """
        if identity not in self._loaded:
            data = self.file_of(identity)
            if data is None:
                return None
            try:
                self._loaded[identity] = load_tried_policy(data, self.first.backend)
            except ReflexarcError as error:
                raise type(error)(f"{self._log.path}: {identity[:12]}: {error}") from None
        return self._loaded[identity]

    def file_of(self, identity: str) -> bytes | None:
        """The file of a policy beside the first one; None: the log does not hold it."""
        if identity in self._absent:
            return None
        if identity in self._found:
            return self._found[identity]
        for data in self._files():
            found = policy_hash(data)
            if found == identity:
                self._found[identity] = data
                return data
            if found not in self._found and self._found_bytes < KEPT_BYTES:
                self._found[found] = data
                self._found_bytes += len(data)
        self._absent.add(identity)
        return None

    def knows(self, identity: str) -> bool:
        """Whether the log says that this policy took its part in it."""
        return identity in self._loaded or self.file_of(identity) is not None

    def _files(self) -> Iterator[bytes]:
        for name in self._log.attachments:
            if name.startswith(ATTACHED_BESIDE):
                yield self._log.attachments[name]
        for record in self._log.records(self._log.topic(SWAP.name)):
            data = _policy_in(self._log, record)
            if data:
                yield data


class ServedControllers(Mapping[str, Controller]):
    """The controllers of the policies that took over: those whom somebody asked for.

    Args:
        served: the policies.
        first: the controller of the first one.
    """

    def __init__(self, served: ServedPolicies, first: Controller) -> None:
        self._served, self._first = served, first
        self._made: dict[str, Controller] = {}

    def __getitem__(self, identity: str) -> Controller:
        if identity not in self._made:
            policy = self._served.named(identity)
            if policy is None:
                raise KeyError(identity)
            self._made[identity] = controller_for(policy, self._first)
        return self._made[identity]

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)


def _policy_in(log: Log, record: Record) -> bytes:
    try:
        return decode(log, record, Swap).policy
    except LogError:
        return b""
