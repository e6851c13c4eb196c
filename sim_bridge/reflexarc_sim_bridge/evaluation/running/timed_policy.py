"""A policy with a watch: how long its decisions take, without any influence on them."""

import time
from typing import Any


class TimedPolicy:
    """Decides as another policy does, and adds up the time.

    Args:
        policy: decides.
    """

    def __init__(self, policy: Any) -> None:
        self._policy = policy
        self.decisions = 0
        """Of single agents."""
        self.decided_s = 0.0

    def decide(self, retinas: Any, *memories: Any) -> Any:
        """See `Policy` and `RememberingPolicy`."""
        began_s = time.perf_counter()
        answer = self._policy.decide(retinas, *memories)
        self.decided_s += time.perf_counter() - began_s
        self.decisions += len(retinas)
        return answer
