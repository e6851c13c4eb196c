"""What a log says of policies beside its first one: who served, and what a shadow preferred."""

from collections.abc import Iterable
from dataclasses import dataclass

from reflexarc_logs.reading.reader import Log, decode
from reflexarc_runtime.messages.topics import KEYFRAME, SHADOW, SWAP
from reflexarc_runtime.messages_pb2 import Keyframe, Shadow


@dataclass
class CandidatesSeen:
    """In numbers."""

    served: tuple[str, ...] = ()
    """Who decided, as the keyframes say, in order; each hash once for each of its turns."""
    shadow_hash: str = ""
    """Who watched last; empty: nobody."""
    compared: int = 0
    """Ticks at which somebody watched."""
    different: int = 0
    """Ticks at which it preferred another action."""
    faults: int = 0


def candidates_seen(log: Log, topics: Iterable[str]) -> CandidatesSeen | None:
    """Read it; None, and nothing is read, where a log has neither swaps nor shadows.

    Args:
        log: the log.
        topics: the names of its topics.

    Raises:
        LogError: the log cannot be read.
    """
    shadow, keyframe = log.topic(SHADOW.name), log.topic(KEYFRAME.name)
    if not {shadow, log.topic(SWAP.name)} & {*topics}:
        return None
    seen = CandidatesSeen()
    for record in log.records(shadow, keyframe):
        if record.topic == shadow:
            _count(seen, decode(log, record, Shadow))
        else:
            name = decode(log, record, Keyframe).policy_hash
            if name and seen.served[-1:] != (name,):
                seen.served = (*seen.served, name)
    return seen


def _count(seen: CandidatesSeen, said: Shadow) -> None:
    seen.shadow_hash = said.policy_hash
    seen.compared += 1
    seen.faults += bool(said.fault)
    seen.different += not said.fault and said.winner != said.drove
