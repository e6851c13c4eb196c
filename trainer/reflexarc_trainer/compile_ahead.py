"""A learner's code is compiled by a second process while this one compiles its world.

That is done once for each state of the sources, and takes either of them many seconds of one
processor; Numba compiles one function at a time, so a thread would not help. What the other process
compiles it leaves in the cache, where this one finds it. If it fails, this one compiles all.
"""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.compile_cache import is_kept
from reflexarc_trainer import batched_learner, online_learner
from reflexarc_trainer.config import TrainConfig

_LONGEST_S = 300.0
"""A process that takes longer is stuck."""
_WORLD, _LEARNERS = "kernel.advance", {"batched": "batched.learn", "online": "online_learner.drive"}


@contextlib.contextmanager
def learner_compiled_meanwhile(config: TrainConfig) -> Iterator[None]:
    """Within it this process makes a world; afterwards the learner of a run is compiled, too."""
    helper = _start(config) if _is_worth_it(config) else None
    try:
        yield
    except BaseException:
        _stop(helper)
        raise
    if helper:
        with contextlib.suppress(subprocess.TimeoutExpired):
            helper.wait(_LONGEST_S)
        _stop(helper)


def compile_learner(config: TrainConfig) -> None:
    """Compile the code that a run learns with, unless that is done: it learns for no step."""
    if config.learner.form == "batched":
        batched_learner.compile_learner(config)
    else:
        online_learner.compile_learner(config)


def _is_worth_it(config: TrainConfig) -> bool:
    is_alone = len(os.sched_getaffinity(0)) < 2
    return not is_alone and not is_kept(_WORLD) and not is_kept(_LEARNERS[config.learner.form])


def _start(config: TrainConfig) -> subprocess.Popen[str] | None:
    command = [sys.executable, "-m", __name__]
    silent = subprocess.DEVNULL
    try:
        helper = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=silent, stderr=silent, text=True
        )
        assert helper.stdin is not None, "a pipe was asked for"
        with helper.stdin as pipe:
            json.dump(config.resolved(), pipe)
    except OSError:  # no such process any more, or none to be had
        return None
    return helper


def _stop(helper: subprocess.Popen[str] | None) -> None:
    if helper:
        helper.kill()
        helper.wait()


def main() -> None:
    """The other process: a resolved configuration comes in on standard input."""
    try:
        config = TrainConfig.from_resolved(json.load(sys.stdin))
    except (ValueError, UsageError) as error:
        print(
            f"compile_ahead: expected a configuration on standard input: {error}", file=sys.stderr
        )
        raise SystemExit(2) from None
    compile_learner(config)


if __name__ == "__main__":
    main()
