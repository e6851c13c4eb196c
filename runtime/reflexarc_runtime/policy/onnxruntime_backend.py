"""The onnxruntime backend: runs any ONNX operator, on one thread.

It agrees with the NumPy backend in the action, and in the Q-values to the contract's `q_tolerance`.

Nothing else imports onnxruntime. From version 1.29 on it tells its maker about the machine that it
is imported on: it looks a name up and keeps an identifier below the home folder. That is switched
off before the import; and `policy.py` imports this module only where a policy runs on it.
"""

import os

import numpy as np

os.environ["ORT_DISABLE_TELEMETRY"] = "1"  # read at the import

import onnxruntime  # after its switch

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.errors import DecisionEndedError, PolicyError
from reflexarc_runtime.policy.onnxruntime_refusal import refusal


class OnnxruntimeGraph:
    """Runs an exported policy graph with onnxruntime on one thread of the CPU.

    Raises:
        PolicyError: onnxruntime refuses the model.
    """

    name = "onnxruntime"

    def __init__(self, model: bytes) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        options.inter_op_num_threads = 1
        options.log_severity_level = 4
        self._run_options = onnxruntime.RunOptions()
        try:
            self._session = onnxruntime.InferenceSession(
                model, options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime raises classes of its own, one a status code
            raise PolicyError(f"onnxruntime refuses the model: {refusal(error)}") from None

    def run(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`; stacks are (n, frames, eyes, rays, channels)."""
        if memories is None:
            q_values, actions = self._compute(["q_values", "action"], {"retina": retinas})
            return np.asarray(q_values, np.float32), np.asarray(actions, np.int64), None
        q_values, actions, following = self._compute(
            ["q_values", "action", "state_next"], {"retina": retinas, "state": memories}
        )
        return (
            np.asarray(q_values, np.float32),
            np.asarray(actions, np.int64),
            np.asarray(following, np.float32),
        )

    def end_run(self) -> None:
        """See `Graph.end_run`: onnxruntime looks at this flag between two operators."""
        self._run_options.terminate = True

    def _compute(
        self, names: list[str], feeds: dict[str, RetinaBatch | Memories]
    ) -> "list[np.ndarray]":
        if self._run_options.terminate:  # it was meant for a run that has ended since
            self._run_options.terminate = False
        try:
            return self._session.run(names, feeds, self._run_options)  # type: ignore[no-any-return]
        except Exception as error:
            if self._run_options.terminate:
                raise DecisionEndedError("the run was ended from another thread") from error
            raise PolicyError(refusal(error)) from None
