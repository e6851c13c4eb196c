"""The flag that says what computes a policy, and the trial before anything else computes it."""

from pathlib import Path
from typing import Literal

BackendName = Literal["numpy", "onnxruntime"]


def try_policy(path: Path | str, backend: BackendName) -> None:
    """Let a process of its own load a policy first where it may hang: onnxruntime's graphs loop.

    Raises:
        PolicyError: it is refused, hangs, or breaks the process.
    """
    if backend == "numpy":
        return
    from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy

    load_tried_policy(Path(path), backend)
