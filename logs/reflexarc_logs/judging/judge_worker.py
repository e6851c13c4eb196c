"""A worker that judges logs: `python -m reflexarc_logs.judging.judge_worker`."""

import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judge_log import judge_log
from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.crew.worker import serve
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.policy import LoadedPolicy


def main() -> None:
    """Judge logs until the input ends."""
    serve(_do, "logs to judge")


def judge_plain(plain: dict[str, Any]) -> dict[str, Any]:
    """Judge one log.

    Args:
        plain: `log`, `name`, `policy` and `hash` of it, `backend` (empty: what the log names),
            and `limits`.

    Raises:
        LogError: the log cannot be read, or not be judged.
        PolicyError, ContractError: the policy is not intact, or another one by now.
    """
    log = read_log(Path(plain["log"]))
    backend = plain["backend"] or log.run.replay_backend.value
    candidate = _candidate(plain["policy"], plain["hash"], backend)
    return judge_log(log, candidate, FlipLimits(**plain["limits"]), plain["name"]).to_plain()


@lru_cache(maxsize=2)
def _candidate(path: str, policy_hash: str, backend: str) -> LoadedPolicy:
    """The candidate, loaded once for each backend."""
    found = load_tried_policy(Path(path), backend)
    if found.policy_hash != policy_hash:
        raise PolicyError(f"{path}: another policy was written while this one was judged")
    return found


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    """Judge one log; `path` are the places where the parent finds modules."""
    sys.path += [place for place in plain["path"] if place not in sys.path]
    return judge_plain(plain)


if __name__ == "__main__":
    main()
