"""Loads a policy for onnxruntime after a process of its own has: its graph may loop or be huge."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.trial import Finding, Trial
from reflexarc_runtime.policy.model_file import policy_hash, read_model
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy, load_policy

_PASSED: set[str] = set()
"""Hashes of the files that a trial let pass: an evaluation loads the same one for each cell."""


def load_tried_policy(
    source: Path | str | bytes,
    backend: Backend | str,
    *,
    verify: bool = True,
    bounds: Bounds | None = None,
) -> LoadedPolicy:
    """Load a policy: see `load_policy`. What onnxruntime computes is tried first, once a process.

    The NumPy backend bounds memory and work itself, and has no operator that loops.

    Raises:
        PolicyError: see `load_policy`; or it hangs, or takes too much memory.
        ContractError: see `load_policy`.
    """
    if Backend(backend) is Backend.ONNXRUNTIME:
        _try(source)
    return load_policy(source, backend, verify=verify, bounds=bounds)


def _try(source: Path | str | bytes) -> None:
    identity = policy_hash(source if isinstance(source, bytes) else read_model(Path(source)))
    if identity in _PASSED:
        return
    if isinstance(source, bytes):
        finding_of(source, "policy", _found)
    else:
        _found(Path(source))
    _PASSED.add(identity)


def _found(path: Path) -> Finding:
    with Trial(path, Backend.ONNXRUNTIME.value) as trial:
        return trial.finding()


def finding_of(data: bytes, name: str, find: Callable[[Path], Finding]) -> Finding:
    """What a trial finds out of the bytes of a policy, whatever lies by now where they came from.

    Args:
        data: the bytes.
        name: what errors call them.
        find: tries a file.

    Raises:
        PolicyError: see `Trial.finding`.
    """
    with TemporaryDirectory(prefix="reflexarc-policy-") as folder:
        path = Path(folder) / "policy.onnx"
        path.write_bytes(data)
        try:
            return find(path)
        except PolicyError as error:
            raise PolicyError(str(error).replace(str(path), name)) from None
