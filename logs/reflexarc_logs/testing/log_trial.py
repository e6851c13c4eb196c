"""What the test of a log does: it replays it, or judges a candidate on it."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judge_log import judge_log
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.testing.failure_text import judgement_failure, replay_failure
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.policy import LoadedPolicy


def limits_of(words: Mapping[str, str]) -> FlipLimits:
    """Limits from words by their names in an ini file.

    Raises:
        UsageError: a word that is none.
    """
    most, margin = words.get("max_reversals", ""), words.get("margin", "0")
    try:
        numbers = int(most) if most else None, float(margin)
    except ValueError:
        raise UsageError(
            f"--max-reversals, --margin: expected numbers, got {most[:20]!r} and {margin[:20]!r}"
        ) from None
    window = words.get("from", ""), words.get("to", "")
    return FlipLimits(words.get("max_flips", ""), *numbers, *window)


@dataclass(frozen=True)
class LogTrial:
    """How logs are tested."""

    policy: Path | None
    """The candidate's file; None: each log is replayed with the policy that it carries."""
    limits: FlipLimits
    """What a candidate may differ by."""
    here: Path
    """The folder in which the reader types commands."""

    def failure(self, path: Path) -> str:
        """Why a log's test fails; empty if it passes.

        Raises:
            LogError: the log cannot be read, or not be judged.
            PolicyError, ContractError: a policy is not intact.
        """
        log = read_log(path)
        if self.policy is None:
            report = replay(log)
            return replay_failure(log, self.typed(path), report) if report.exit_status else ""
        found = judge_log(log, self._candidate(log.run.replay_backend.value), self.limits)
        if not found.exit_status:
            return ""
        typed = self.typed(path), found, self.typed(self.policy), self.limits
        return judgement_failure(log, *typed)

    def typed(self, path: Path) -> Path:
        """A path as the reader would type it."""
        near = Path(os.path.relpath(path, self.here))
        return Path(os.path.abspath(path)) if near.parts[:1] == ("..",) else near

    def _candidate(self, backend: str) -> LoadedPolicy:
        """The candidate, loaded once for each backend."""
        if backend not in self._loaded:
            assert self.policy is not None
            self._loaded[backend] = load_tried_policy(self.policy, backend)
        return self._loaded[backend]

    @cached_property
    def _loaded(self) -> dict[str, LoadedPolicy]:
        return {}
