"""A run, stopped anywhere and continued to the same bits.

One .npz file without pickled objects: the configuration, the weights, the trace or the optimiser,
the pending actions, the random streams, the worlds, the history, and the best weights so far.
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
    """What a file holds."""

    config: TrainConfig
    arrays: Arrays
    """Of `Learner.arrays`."""
    history: list[Row]
    best: npt.NDArray[np.float64]
    """Weights of the best validation point, none before the first: (parameters,) or (0,)."""

    def learner(self) -> Learner:
        """The learner where it was."""
        learner = new_learner(self.config)
        learner.restore(self.arrays)
        return learner


def save(path: Path, learner: Learner, history: list[Row], best: npt.NDArray[np.float64]) -> None:
    """Write a checkpoint, whole or not at all; see `Checkpoint`."""
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
        UsageError: there is none, or it is not one that this version wrote.
    """
    arrays = _read(path)
    missing = [name for name in (_FORMAT, _CONFIG, _HISTORY, _BEST) if name not in arrays]
    if missing or int(arrays[_FORMAT]) != FORMAT:
        raise UsageError(f"{path}: expected a checkpoint of format {FORMAT}; train anew")
    return Checkpoint(
        config=TrainConfig.from_resolved(json.loads(str(arrays[_CONFIG]))),
        arrays={k.removeprefix(_LEARNER): v for k, v in arrays.items() if k.startswith(_LEARNER)},
        history=from_table(arrays[_HISTORY].tolist()),
        best=arrays[_BEST],
    )


def _read(path: Path) -> Arrays:
    try:
        # From memory: NumPy leaves a file open that turns out to be no archive.
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as archive:
            return dict(archive)
    except FileNotFoundError:
        raise UsageError(f"{path}: no checkpoint here; give the checkpoint.npz of a run") from None
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        raise UsageError(f"{path}: expected a checkpoint, cannot read it ({reason})") from None
