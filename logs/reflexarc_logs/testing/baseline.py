"""Accepts a new baseline: a log in which the decisions of now stand in the place of the old ones.

What came to the loop stays as it is, byte for byte; ticks, commands and keyframes are those of this
software, and of the candidate if one is given, which is then attached. The new log takes the place
of the old one only after it has been replayed.
"""

import hashlib
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from reflexarc_logs.cutting.incident_part import INCIDENT
from reflexarc_logs.judging.comparable import check_comparable
from reflexarc_logs.reading.incidents import find_incidents
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.asked_policy import attached_policy
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.testing.baseline_file import write_baseline
from reflexarc_logs.testing.decided_anew import DecidedAnew, decide_anew
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.policy import LoadedPolicy


@dataclass(frozen=True)
class NewBaseline:
    """What was accepted."""

    path: Path
    old_sha256: str
    new_sha256: str
    old_policy: str
    new_policy: str
    said: str
    """How the decisions differ, in words."""

    def lines(self, path: Path | None = None) -> list[str]:
        """Old and new, for people; the log as they would type it."""
        return [
            f"{path or self.path}: {self.said}",
            f"  old: sha256 {self.old_sha256}, policy {self.old_policy[:12]}",
            f"  new: sha256 {self.new_sha256}, policy {self.new_policy[:12]}",
        ]


def accept(path: Path, candidate: Path | None) -> NewBaseline | None:
    """Put the decisions of now in the place of those in a log.

    Args:
        path: the log; it is replaced.
        candidate: whose decisions; None: those of the policy that the log carries.

    Returns:
        None if there is nothing to accept: the log replays as it is.

    Raises:
        LogError: it cannot be read, decided anew, or replaced; it stays as it was.
        PolicyError, ContractError: a policy is not intact.
    """
    path = path.resolve()
    log = read_log(path)
    policy = _policy(log, candidate)
    is_other = policy.policy_hash != log.run.policy_hash
    if not is_other and not replay(log).exit_status:
        return None
    if is_other:
        check_comparable(log, policy.contract)
    anew = decide_anew(log, policy)
    said = "; ".join(_difference(log, anew))
    old = _sha256(path)
    try:
        with TemporaryDirectory(prefix=".baseline-", dir=path.parent) as folder:
            new = Path(folder) / path.name
            write_baseline(log, policy, anew, new, {"of": old, "said": said})
            said += _check(log, new)
            shutil.copymode(path, new)
            os.replace(new, path)
    except OSError as error:
        raise LogError(f"{path}: cannot be replaced: {error.strerror}; it is as it was") from None
    policies = log.run.policy_hash, policy.policy_hash
    return NewBaseline(path, old, _sha256(path), *policies, said)


def _policy(log: Log, candidate: Path | None) -> LoadedPolicy:
    if candidate is None:
        return attached_policy(log)
    return load_tried_policy(candidate, log.run.replay_backend)


def _difference(log: Log, anew: DecidedAnew) -> Iterator[str]:
    yield f"{anew.different} of {len(anew.ticks)} ticks are decided otherwise"
    if anew.counts["winner"]:
        yield f"at {anew.counts['winner']} another action is preferred"
    if anew.counts["action"]:
        yield f"at {anew.counts['action']} another one is done"
    if anew.counts["verdict"]:
        yield f"at {anew.counts['verdict']} with another verdict"
    if anew.first:
        yield f"first at {anew.first}"


def _check(log: Log, path: Path) -> str:
    """Replay the new log; what its reader should know beside.

    Raises:
        LogError: it does not replay.
    """
    new = read_log(path)
    report = replay(new)
    if report.exit_status:
        first = repr(report).partition(": ")[2].rstrip(">")
        raise LogError(
            f"{log.path}: decided anew it does not replay ({first}); it is as it was: record it "
            "again"
        )
    wanted = log.metadata.get(INCIDENT, {})
    if not wanted or any(
        (one.kind, str(one.tick)) == (wanted.get("kind"), wanted.get("tick"))
        for one in find_incidents(new)
    ):
        return ""
    return f"; the {wanted.get('kind', 'incident')} that it showed is no longer in it"


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
