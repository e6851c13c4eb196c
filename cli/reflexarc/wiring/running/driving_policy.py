"""The policy that a run begins with: tried and loaded from the very bytes that were accepted."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reflexarc_runtime.contract.bounds import Bounds
    from reflexarc_runtime.loop.trials.trial import Finding
    from reflexarc_runtime.policy.policy import LoadedPolicy


def tried_policy(
    path: Path, accepted: bytes, backend: str, bounds: "Bounds"
) -> "tuple[Finding, LoadedPolicy]":
    """Load a policy, after a process of its own has; its file is not read again.

    Args:
        path: what errors call it.
        accepted: the bytes of the file.
        backend: what computes it.
        bounds: what it may ask for at most.

    Raises:
        PolicyError, ContractError: see `Trial.finding` and `load_policy`.
    """
    from reflexarc_runtime.loop.trials.forked_process import forked_if_alone
    from reflexarc_runtime.loop.trials.trial import Trial
    from reflexarc_runtime.policy.policy import load_policy

    with Trial(path, backend, begin=partial(forked_if_alone, data=accepted)) as trial:
        # Meanwhile everything else that the loop will need is loaded.
        import reflexarc_runtime.bus
        import reflexarc_runtime.controller  # noqa: F401

        finding = trial.finding()
    return finding, load_policy(accepted, backend, bounds=bounds, name=str(path))
