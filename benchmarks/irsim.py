"""Our world against IR-SIM (PyPI `ir-sim`, MIT) in an equal scene, one thread each.

    python -m venv /tmp/irsim && /tmp/irsim/bin/pip install ir-sim
    python benchmarks/irsim.py --python /tmp/irsim/bin/python           a table
    python benchmarks/irsim.py --python /tmp/irsim/bin/python --json    the same for a program

IR-SIM brings many packages: it lives in an environment of its own. Equal: as many upright boxes of
the same sizes as an agent of ours has near it in the reference field with 0.5 a square metre, a
lidar of 16 beams over 180° and 5 m, steps of 0.1 s, a point (a disc of 1 cm) whose heading and
speed are commanded, contacts noticed. IR-SIM's robot has a differential drive and goes in a circle
among its boxes, through them where it meets one; it draws nothing and logs nothing. Ours turns
likewise, meets obstacles, is put elsewhere, and its world is endless. Rates are steps of one robot
a second, the best of several rounds, ours and theirs in turn.
"""

import argparse
import json
import math
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from world_scenes import Advance, Scene, advancing, elapsed_s

from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.single_agent import OneAgent

ROUNDS = 5
THEIR_STEPS, OUR_AGENT_STEPS = 300, 100_000
AGENTS = (1, 4096)
SIDE_M, SPEED_MPS, TURN_RADPS = 12.0, 1.0, 0.5
WIDTH_M, LENGTH_M = (0.3, 1.5), (0.3, 1.2)

THEIRS = """
import json, os, sys, time
answers = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # where it logs
from importlib.metadata import version
try:
    import irsim
except ImportError:
    sys.exit(3)
env = irsim.make(sys.argv[1], display=False, disable_all_plot=True, log_level="ERROR")
steps, action = int(sys.argv[2]), [float(sys.argv[3]), float(sys.argv[4])]
for _ in range(30):
    env.step(action)
print(json.dumps({"version": version("ir-sim"), "obstacles": len(env.obstacle_list)}), file=answers)
for _ in sys.stdin:
    start_s = time.perf_counter()
    for _ in range(steps):
        env.step(action)
        ranges = env.robot.get_lidar_scan()["ranges"]
    print(json.dumps(steps / (time.perf_counter() - start_s)), file=answers)
"""


class Theirs:
    """IR-SIM in a process of its own: one round for each line that it is given."""

    def __init__(self, python: str, scene: Path) -> None:
        """Start it.

        Raises:
            SystemExit: that Python has no IR-SIM.
        """
        numbers = (str(THEIR_STEPS), str(SPEED_MPS), str(TURN_RADPS))
        command = [python, "-I", "-c", THEIRS, str(scene), *numbers]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        line = self._answer()
        if not line:
            raise SystemExit(
                f"irsim: expected IR-SIM in {python}; python -m venv /tmp/irsim && "
                "/tmp/irsim/bin/pip install ir-sim, then --python /tmp/irsim/bin/python"
            )
        self.about: dict[str, Any] = json.loads(line)

    def rate_hz(self) -> float:
        """Steps a second of one round."""
        assert self._process.stdin is not None, "it was opened with a pipe"
        print("again", file=self._process.stdin, flush=True)
        return float(json.loads(self._answer()))

    def close(self) -> None:
        """End it."""
        self._process.communicate()

    def _answer(self) -> str:
        assert self._process.stdout is not None, "it was opened with a pipe"
        return self._process.stdout.readline()


class Ours:
    """Agents of ours that turn as IR-SIM's robot does."""

    def __init__(self, agents: int) -> None:
        """Place them, and let them go until contacts come evenly."""
        scene = Scene(agents=agents)
        contract = scene.simulation().contract
        turn = Action("turn", SPEED_MPS, 0.0, TURN_RADPS)
        contract = replace(contract, actions=(turn, replace(turn, name="again")))
        self.simulation = Simulation(scene.world(), contract, np.arange(agents, dtype=np.uint64))
        self._advance = (
            one_advancing(self.simulation) if agents == 1 else advancing(self.simulation)
        )
        self._actions = np.zeros((max(60, OUR_AGENT_STEPS // agents), agents), np.int64)
        elapsed_s(self._advance, self._actions[:60])

    def rate_hz(self) -> float:
        """Steps of one agent a second, of all agents together, of one round."""
        return self._actions.size / elapsed_s(self._advance, self._actions)


def one_advancing(simulation: Simulation) -> Advance:
    """What the Gymnasium environment calls: one agent without threads."""
    step = OneAgent(simulation).step_and_sense
    return lambda actions: step(0)


def scene_text(boxes: int) -> str:
    """IR-SIM's description of the scene."""
    generator = np.random.default_rng(0)
    robot = (
        f"world: {{height: {SIDE_M}, width: {SIDE_M}, step_time: 0.1, "
        "collision_mode: 'unobstructed'}\nrobot:\n  - kinematics: {name: 'diff'}\n"
        f"    shape: {{name: 'circle', radius: 0.01}}\n    state: [{SIDE_M / 2}, 4.0, 0]\n"
        "    sensors:\n      - {name: 'lidar2d', range_min: 0, range_max: 5.0, "
        f"angle_range: {math.pi:.6f}, number: 16}}\nobstacle:\n"
    )
    for _ in range(boxes):
        length_m, width_m = generator.uniform(*LENGTH_M), generator.uniform(*WIDTH_M)
        x_m, y_m = generator.uniform(1.0, SIDE_M - 1.0, 2)
        robot += (
            f"  - shape: {{name: 'rectangle', length: {length_m:.3f}, width: {width_m:.3f}}}\n"
            f"    state: [{x_m:.3f}, {y_m:.3f}, 0]\n"
        )
    return robot


def measured(python: str) -> dict[str, Any]:
    """Best rates and their ratios."""
    set_thread_count(1)
    ours = {agents: Ours(agents) for agents in AGENTS}
    counts = ours[AGENTS[-1]].simulation.params.agents.near_counts
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(scene_text(round(float(counts.sum(axis=(1, 2)).mean()))))
        theirs = Theirs(python, path)
        rounds = [
            (theirs.rate_hz(), *(mine.rate_hz() for mine in ours.values())) for _ in range(ROUNDS)
        ]
        theirs.close()
    best = np.array(rounds).max(axis=0)
    rates = {
        f"ours, {agents} agents": float(rate) for agents, rate in zip(AGENTS, best[1:], strict=True)
    }
    ratios = {f"{name}, ratio": rate / float(best[0]) for name, rate in rates.items()}
    return {**theirs.about, "IR-SIM, steps a second": float(best[0]), **rates, **ratios}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--python", default=sys.executable, help="an interpreter that has ir-sim")
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args()
    if shutil.which(options.python) is None:
        parser.error(f"--python: no interpreter is at {options.python}")
    found = measured(options.python)
    if options.json:
        print(json.dumps(found))
        return
    for name, value in found.items():
        print(f"{name:26}{value:>14,.0f}" if isinstance(value, float) else f"{name:26}{value:>14}")


if __name__ == "__main__":
    main()
