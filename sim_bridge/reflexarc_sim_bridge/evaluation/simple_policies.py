"""Policies that ignore what they see: the baseline for every other policy."""

import numpy as np

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch


class BlindPolicy:
    """Never steers: always the first action, stay. Scores 2ρR contacts a metre."""

    def __init__(self, actions: int = 3) -> None:
        self._actions = actions

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """All values equal: the first action wins."""
        n = len(retinas)
        return np.zeros((n, self._actions), np.float32), np.zeros(n, np.int64)


class RandomPolicy:
    """Draws every action anew from one stream: same seed and same calls, same actions."""

    def __init__(self, seed: int, actions: int = 3) -> None:
        self._generator = np.random.default_rng(seed)
        self._actions = actions

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Values uniform in [0, 1); the greatest wins."""
        q_values = self._generator.random((len(retinas), self._actions), np.float32)
        return q_values, q_values.argmax(axis=1)
