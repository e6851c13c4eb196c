"""Who is measured, from the flags of `evaluate`."""

import sys
from collections.abc import Sequence
from pathlib import Path

from reflexarc.wiring.policy_trials import BackendName, try_policy
from reflexarc_baselines.registry import HOMES, source_of
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, RANDOM
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant


def entrants_of(
    policies: Sequence[Path],
    controllers: Sequence[str],
    baselines: Sequence[str],
    *,
    guard: bool,
    rate_hz: float | None,
    backend: BackendName = "numpy",
) -> list[Entrant]:
    """Files, then controllers, then baselines, each by the name that it was given.

    Baselines are those of `reflexarc_baselines`, and `blind` and `random`.

    Raises:
        UsageError: nobody, somebody twice, or a controller without a class.
        PolicyError: a file is refused by a backend that has to be tried.
    """
    for text in controllers:
        if ":" not in text:
            raise UsageError(f"--controller: expected module:Class or file.py:Class, got {text!r}")
    if "" not in sys.path:
        sys.path.append(str(Path.cwd()))  # where whoever names a module has it
    named = [(str(path), str(path)) for path in policies]
    named += [(text, text) for text in controllers]
    named += [(name, name if name in (BLIND, RANDOM) else source_of(name)) for name in baselines]
    if not named:
        raise UsageError("evaluate: expected a policy, --controller or --baseline, got none")
    for path in policies:
        try_policy(path, backend)
    return [Entrant(name, source, guard, rate_hz, backend) for name, source in named]


def sources_of_baselines() -> list[str]:
    """The sources of the baselines that ship with this package."""
    return [source_of(name) for name in HOMES]


def entrant_of(
    text: str, *, guard: bool, rate_hz: float | None, backend: BackendName = "numpy"
) -> Entrant:
    """One of them, of whatever kind its text says: a baseline's name, a class, or a file."""
    if text in HOMES or text in (BLIND, RANDOM):
        [one] = entrants_of((), (), (text,), guard=guard, rate_hz=rate_hz)
    elif ":" in text and not Path(text).exists():
        [one] = entrants_of((), (text,), (), guard=guard, rate_hz=rate_hz)
    else:
        [one] = entrants_of((Path(text),), (), (), guard=guard, rate_hz=rate_hz, backend=backend)
    return one
