"""A suite of two cells that is measured in a moment, and contenders for it."""

from pathlib import Path

SUITE = """\
name = "small"
version = 1
worlds = 3
lanes = 2
free_paths = 3
turner_s = 2

[[families]]
name = "rectangles"

[[families.cells]]
tier = "reference"
world = "reference-1"

[[families]]
name = "senses"

[[families.cells]]
tier = "noisy"
world = "noisy"
"""

CONTROLLERS = """\
import os
import random

import numpy as np

from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


class Mine:
    contract = reference_contract()

    def decide(self, retinas):
        rays = retinas[:, -1, 0, :, 0].astype(np.float32)
        left, right = rays[:, :8].mean(axis=1), rays[:, 8:].mean(axis=1)
        q_values = np.stack([np.full(len(rays), -60.0), -left, -right], axis=1).astype(np.float32)
        return q_values, q_values.argmax(axis=1)


class Gambler(Mine):
    '''Draws from the global generators, and from the order of a set of words.'''

    def decide(self, retinas):
        first = next(iter({"stay", "left", "right"}))
        bias = np.random.random(3) + random.random() + len(first)
        q_values = np.random.random((len(retinas), 3)) + bias
        return q_values.astype(np.float32), q_values.argmax(axis=1)


class Counter(Mine):
    '''What it does depends on how often it was asked.'''

    def __init__(self):
        self.asked = 0

    def decide(self, retinas):
        self.asked += 1
        actions = np.full(len(retinas), self.asked // 7 % 3)
        return np.zeros((len(retinas), 3), np.float32), actions


class Broken(Mine):
    def decide(self, retinas):
        raise ValueError("no idea\\nat all")


class Deadly(Mine):
    def decide(self, retinas):
        os._exit(7)
"""


def write_small_suite(folder: Path) -> tuple[Path, Path]:
    """The file of the suite, and that of the contenders."""
    suite, controllers = folder / "small.toml", folder / "small_controllers.py"
    suite.write_text(SUITE)
    controllers.write_text(CONTROLLERS)
    return suite, controllers
