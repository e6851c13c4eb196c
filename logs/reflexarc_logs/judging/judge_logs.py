"""Judges a candidate policy on many logs, shared among processes.

The report's bytes depend on the logs, the candidate and the limits only: not on the number of
processes, the order in which the logs are named, or where they lie.
"""

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judge_worker import judge_plain
from reflexarc_logs.judging.judgement import LogJudgement
from reflexarc_logs.judging.judgement_report import Judgement, worst_first
from reflexarc_logs.judging.log_names import named, without_place
from reflexarc_logs.judging.log_work import (
    LogFailedError,
    Progress,
    job_count,
    share_work,
    sizes_first,
)
from reflexarc_runtime.policy.model_file import policy_hash, read_model
from reflexarc_runtime.policy.policy import Backend, load_contract

_WORKER = "reflexarc_logs.judging.judge_worker"
NO_LIMITS = FlipLimits()


def judge_logs(
    paths: Iterable[Path],
    policy: Path | str,
    limits: FlipLimits = NO_LIMITS,
    *,
    backend: Backend | str | None = None,
    jobs: int = 1,
    progress: Progress = lambda done, of: None,
) -> Judgement:
    """Judge a candidate on logs, each by itself.

    Args:
        paths: of the logs; see `reading.log_paths`.
        policy: the candidate's file.
        limits: what it may differ by, and where that is counted.
        backend: what shall compute it; by default, what each log names.
        jobs: processes; 0: one for each processor.
        progress: called with the logs done and the logs in all.

    Raises:
        PolicyError, ContractError: the policy is not intact.
        UsageError: a number of processes that is none.
    """
    identity, places = _checked(Path(policy)), named(paths)
    common = {
        "policy": str(policy),
        "hash": identity,
        "backend": "" if backend is None else Backend(backend).value,
        "limits": dataclasses.asdict(limits),
    }
    tasks = {
        name: {"log": str(places[name]), "name": name, **common} for name in sizes_first(places)
    }
    answers = share_work(_WORKER, judge_plain, tasks, job_count(jobs), progress)
    logs = [_judgement(name, answers[name], places[name]) for name in places]
    return Judgement(Path(policy).name, identity, limits.words(), worst_first(logs))


def _checked(policy: Path) -> str:
    """The hash of a policy; what is wrong with it is said once, not for each log."""
    load_contract(policy, bounds=None)
    return policy_hash(read_model(policy))


def _judgement(name: str, answer: dict[str, Any] | LogFailedError, path: Path) -> LogJudgement:
    if isinstance(answer, LogFailedError):
        return LogJudgement(name, problem=without_place(str(answer), path))
    return LogJudgement.from_plain(answer)
