"""Checkpoints: a run can stop anywhere and continue to the same bits.

A checkpoint is one .npz file without pickled objects: the configuration, everything that
`Learner.arrays` returns (weights, trace or optimiser, chosen actions, random streams, worlds), the
validation points and the best weights so far.
"""

import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.files import write_atomically
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.run.history import Row, from_table
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.sarsa.learner_interface import Arrays, Learner

FORMAT = 4
"""Version of the file's arrays: 4 has named fields for the learner's single numbers."""

_FORMAT, _CONFIG, _HISTORY, _BEST = "format", "config", "history", "best"
_LEARNER = "learner."


@dataclass(frozen=True)
class Checkpoint:
    """The content of a checkpoint file."""

    config: TrainConfig
    arrays: Arrays
    """What `Learner.arrays` returned."""
    history: list[Row]
    best: npt.NDArray[np.float64]
    """Weights at the best validation point: (parameters,), or (0,) before the first point."""

    def learner(self) -> Learner:
        """The learner in the state that was saved."""
        learner = new_learner(self.config)
        learner.restore(self.arrays)
        return learner


def save(path: Path, learner: Learner, history: list[Row], best: npt.NDArray[np.float64]) -> None:
    """Write a checkpoint file, whole or not at all; the arguments are as in `Checkpoint`."""
    arrays = {_LEARNER + name: array for name, array in learner.arrays().items()}
    buffer = io.BytesIO()
    np.savez(
        buffer,
        allow_pickle=False,
        **{_FORMAT: np.array(FORMAT)},
        **{_CONFIG: np.array(json.dumps(learner.config.resolved()))},
        **{_HISTORY: np.array(history, np.float64).reshape(-1, len(Row._fields))},
        **{_BEST: best},
        **arrays,
    )
    write_atomically(path, buffer.getvalue())


def load(path: Path) -> Checkpoint:
    """Read a checkpoint.

    Raises:
        UsageError: there is no file, it is no checkpoint, or it has another format.
    """
    arrays = _read(path)
    found = arrays[_FORMAT].tolist() if _FORMAT in arrays else None
    if found != FORMAT or not {_CONFIG, _HISTORY, _BEST} <= arrays.keys():
        got = "none" if found is None else f"format {found}"
        raise UsageError(f"{path}: expected a checkpoint of format {FORMAT}, got {got}; train anew")
    return Checkpoint(
        config=TrainConfig.from_resolved(json.loads(str(arrays[_CONFIG]))),
        arrays={k.removeprefix(_LEARNER): v for k, v in arrays.items() if k.startswith(_LEARNER)},
        history=from_table(arrays[_HISTORY].tolist()),
        best=arrays[_BEST],
    )


def _read(path: Path) -> Arrays:
    try:
        # Read into memory first: NumPy leaves a file open that turns out not to be an archive.
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as archive:
            return dict(archive)
    except FileNotFoundError:
        raise UsageError(f"{path}: no checkpoint here; give the checkpoint.npz of a run") from None
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        raise UsageError(f"{path}: expected a checkpoint, cannot read it ({reason})") from None
