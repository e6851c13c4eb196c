"""How fast the world is: agents sensing and stepping, warm.

    python benchmarks/world.py                      a table
    python benchmarks/world.py --density 0.4        of another density than 0.5
    python benchmarks/world.py --figure             growth with rays, obstacles, distance: a picture
    python benchmarks/world.py --first-step         what compilation costs
    ... --json                                      the same for a program

4,096 agents in the reference field, never steering or steering at random (each action held for 3
steps); generation of chunks, swept contact and new places after contacts included. Figures are
millions of agent-steps a second: the best of several rounds, on a machine that does other work too
the least disturbed one, and the median. `chrt -f 50 python …` keeps other work away, as root.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from world_scenes import MODES, Scene, actions_of, advancing, rounds_s

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.native.threads import set_thread_count

FIGURE = Path(__file__).parents[1] / "docs" / "figures" / "world_speed.png"
ROUNDS = 9
STEPS = 30
WARM_UP_STEPS = 60
"""Blind agents begin at free places all at once: so long until contacts come evenly."""
RAYS = (8, 16, 32, 64, 128, 256)
DENSITIES = (0.05, 0.1, 0.2, 0.4, 0.5, 0.8, 1.2, 1.6)
PLACES_M = (0.0, 1e3, 1e6, 1e9, 1e12)
INK, GRID, COLOURS = "#333333", "#dddddd", {"blind": "#0b6e4f", "random": "#a23b3b"}

FIRST_STEP = """
import time
import numpy as np
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.evaluation.reference_field import reference_contract
from reflexarc_sim_bridge.worlds.files import world_named
start_s = time.perf_counter()
simulation = Simulation(world_named("reference-1"), reference_contract(), np.zeros(2, np.uint64))
simulation.sense()
simulation.step(np.zeros(2, np.int64))
print(time.perf_counter() - start_s)
"""


def table(density_per_m2: float) -> list[dict[str, Any]]:
    """Looking, moving and both; threads; policies; then the dearest eye and shapes."""
    plain = Scene(density_per_m2=density_per_m2)
    rich = [
        Scene(density_per_m2=density_per_m2, samples=4, shapes=shapes)
        for shapes in ("upright", "turned", "curves", "turned and curves")
    ]
    rows = []
    for threads in thread_counts():
        for policy in COLOURS:
            for mode in MODES:
                rows += measured([plain], threads, mode, policy)
            rows += measured(rich, threads, "both", policy)
    return rows


def growth(scenes: Sequence[Scene]) -> list[dict[str, Any]]:
    """Both, on all threads."""
    threads = thread_counts()[0]
    return [row for policy in COLOURS for row in measured(scenes, threads, "both", policy)]


def measured(scenes: Sequence[Scene], threads: int, mode: str, policy: str) -> list[dict[str, Any]]:
    """One row a scene, all timed in turn."""
    set_thread_count(threads)
    simulations = [scene.simulation() for scene in scenes]
    for simulation in simulations:
        for actions in actions_of(policy, WARM_UP_STEPS, len(simulation)):
            simulation.step(actions)
    ways = {str(k): advancing(each, MODES[mode]) for k, each in enumerate(simulations)}
    actions = actions_of(policy, STEPS, scenes[0].agents)
    times = rounds_s(ways, actions, ROUNDS)
    return [
        {
            "threads": threads,
            "policy": policy,
            "mode": mode,
            **asdict(scene),
            "near": float(simulation.params.agents.near_counts.sum(axis=(1, 2)).mean()),
            "best": actions.size / float(seconds.min()) / 1e6,
            "median": actions.size / float(np.median(seconds)) / 1e6,
        }
        for scene, simulation, seconds in zip(scenes, simulations, times.values(), strict=True)
    ]


def thread_counts() -> list[int]:
    """All, and one."""
    return sorted({len(os.sched_getaffinity(0)), 1}, reverse=True)


def first_step_s() -> dict[str, float]:
    """Seconds up to the first step in a new process, cache empty and cache filled."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        command = [sys.executable, "-c", FIRST_STEP]
        found = {}
        for state in ("empty cache", "filled cache"):
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, check=True
            )
            found[state] = float(done.stdout)
    return found


def show(rows: list[dict[str, Any]]) -> None:
    """Print as a table."""
    for title in rows[0]:
        print(f"{title:>18}", end="")
    print()
    for found in rows:
        for value in found.values():
            print(f"{value:18.4g}" if isinstance(value, float) else f"{value:>18}", end="")
        print()


def draw(growths: dict[str, list[dict[str, Any]]]) -> None:
    """Three panels: microseconds a step over rays, obstacles near, and distance travelled."""
    figure = Figure(figsize=(11.0, 3.6), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (name, rows) in zip(figure.subplots(1, 3), growths.items(), strict=True):
        draw_panel(axes, name, rows)
    axes = figure.axes[0]
    axes.set_ylabel("µs of the clock an agent-step, all threads")
    axes.legend(frameon=False)
    figure.savefig(FIGURE, format="png", metadata={"Software": None})


def draw_panel(axes: Axes, name: str, rows: list[dict[str, Any]]) -> None:
    """One line a policy."""
    for policy, colour in COLOURS.items():
        mine = [found for found in rows if found["policy"] == policy]
        points = [(found[name], 1.0 / found["best"]) for found in mine]
        x, cost_us = zip(*points, strict=True)
        axes.plot(x, cost_us, "o-", color=colour, markersize=3.5, label=policy)
    if name == "x_m":
        axes.set_xscale("symlog", linthresh=PLACES_M[1])
        axes.set_xticks(PLACES_M, [f"{place_m:g}" for place_m in PLACES_M])
    titles = {"rays": "rays", "near": "obstacles near (ρ 0.05 to 1.6)", "x_m": "begun at x, m"}
    axes.set_xlabel(titles[name], color=INK)
    axes.set_ylim(0.0, 1.1 * axes.get_ylim()[1])
    axes.grid(color=GRID, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)


def law(rows: list[dict[str, Any]], name: str) -> str:
    """How the blind cost grows, in words."""
    blind = [found for found in rows if found["policy"] == "blind"]
    cost_ns = np.array([1e3 / found["best"] for found in blind])
    if name == "x_m":
        return f"dearest place / cheapest place: {cost_ns.max() / cost_ns.min():.2f}"
    each_ns, none_ns = np.polyfit([found[name] for found in blind], cost_ns, 1)
    return f"{none_ns:.0f} ns and {each_ns:.3g} ns for each of {name}"


def main() -> None:
    """What the arguments ask for, as a table, as JSON or as a picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--density", type=float, default=0.50, help="obstacles a square metre")
    parser.add_argument("--figure", action="store_true", help=f"write {FIGURE.name}")
    parser.add_argument("--first-step", action="store_true")
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args()
    try:
        Scene(density_per_m2=options.density).world()
    except WorldError as error:
        parser.error(f"--density: {error}")
    if options.first_step:
        print(json.dumps(first_step_s()))
        return
    if not options.figure:
        rows = table(options.density)
        print(json.dumps(rows, indent=2)) if options.json else show(rows)
        return
    growths = {
        "rays": growth([Scene(rays=rays) for rays in RAYS]),
        "near": growth([Scene(density_per_m2=density) for density in DENSITIES]),
        "x_m": growth([Scene(x_m=place_m) for place_m in PLACES_M]),
    }
    draw(growths)
    if options.json:
        print(json.dumps(growths, indent=2))
        return
    for name, rows in growths.items():
        show(rows)
        print(f"blind: {law(rows, name)}\n")


if __name__ == "__main__":
    main()
