"""The compiled world against the same loops in plain C (`world_c/world.c`), one thread each.

    python benchmarks/world_against_c.py               a table
    python benchmarks/world_against_c.py --json        the same for a program

C is built with every compiler found (gcc, clang) at -O3 -march=native -ffast-math; ratios are to
the faster one. Before anything is timed both run 200 steps of 256 agents from one state: contacts
must be equal, and values of the retinas too, but for rounding: C may contract and reorder.
Then both are timed in turn, in the reference field with 0.5 obstacles a square metre.
`chrt -f 50 python …` keeps other work away, as root.
"""

import argparse
import ctypes
import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from world_scenes import MODES, Advance, Scene, actions_of, advancing, rounds_s

from reflexarc_runtime.arrays import Actions
from reflexarc_sim_bridge.arrays.layout import AGENT_DTYPE, BOXES
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

SOURCE = Path(__file__).parent / "world_c" / "world.c"
FLAGS = ("-O3", "-march=native", "-ffast-math", "-shared", "-fPIC")
COMPILERS = ("gcc", "clang")
COMPARED = Scene(agents=256)
COMPARED_STEPS = 200
STEEPEST = np.float32(1e-9)
MOST_OFF_BY_ONE = 1e-4
"""Share of the values that may differ by 1, where rounding decides."""
STEPS, ROUNDS = 60, 11
WARM_UP_STEPS = 60

_NUMBERS = (
    *("dt_s", "width_m", "side_m", "chunk_m", "ahead_m", "behind_m", "aside_m", "reach_m"),
    *("width_low_m", "width_high_m", "length_low_m", "length_high_m", "range_m"),
)
_COUNTS = ("across", "stream", "columns", "belt_boxes", "belt_columns", "count_steps", "rays")
_TABLES = ("counts", "ahead", "left", "per_ahead", "per_left")
_AGENTS = ("state", "counts", "boxes", "places", "sizes", "belts", "stack")


class CWorld(ctypes.Structure):
    """`World` of world.c."""

    _fields_ = (
        *((name, ctypes.c_double) for name in _NUMBERS),
        *((name, ctypes.c_int64) for name in _COUNTS),
        *((name, ctypes.c_void_p) for name in _TABLES),
    )


class CAgents(ctypes.Structure):
    """`Agents` of world.c."""

    _fields_ = tuple((name, ctypes.c_void_p) for name in _AGENTS)


class Rival:
    """The C world, going on from a copy of a simulation's state."""

    def __init__(self, library: Path, simulation: Simulation) -> None:
        """Copy the state; the arrays live as long as this does."""
        world, eye, agents = simulation.params
        self.state, self.stack = agents.state.copy(), agents.stack.copy()
        self.met = np.zeros(len(simulation), np.bool_)
        self._counts = np.ascontiguousarray(agents.near_counts[:, 0, BOXES])
        self._boxes, self._belts = agents.boxes.copy(), agents.belt_counts.copy()
        self._places, self._sizes = agents.belt_places.copy(), agents.belt_sizes.copy()
        self._motions = motions_of(simulation.contract)
        rays = (eye.ahead, eye.left, *map(_reciprocal, (eye.ahead, eye.left)))
        self._tables = (world.counts[0, 0, 0].copy(), *(row.copy() for row in rays))
        self._world = _c_world(simulation, self._tables)
        belts = (self._places, self._sizes, self._belts)
        rows = (self.state, self._counts, self._boxes, *belts, self.stack)
        self._agents = CAgents(*map(_address, rows))
        self._advance = ctypes.CDLL(str(library)).advance
        self._advance.restype = None

    def advancing(self, tasks: int = MODES["both"]) -> Advance:
        """Let all agents move, or look, or both in one pass."""
        fixed = ctypes.byref(self._world), ctypes.byref(self._agents), _pointer(self._motions)
        n = ctypes.c_int64(len(self.met))
        modes = ctypes.c_bool(tasks & MOVE != 0), ctypes.c_bool(tasks & LOOK != 0)
        met = _pointer(self.met)
        return lambda actions: self._advance(*fixed, _pointer(actions), met, n, *modes)

    @property
    def x_m(self) -> npt.NDArray[np.float64]:
        """Where the agents are, ahead: (n,)."""
        return np.asarray(self.state["cell_x"] * CHUNK_M + self.state["x_m"], np.float64)


def built(folder: Path) -> dict[str, Path]:
    """The C world by the compilers found.

    Raises:
        SystemExit: none is found.
    """
    libraries = {}
    for compiler in filter(shutil.which, COMPILERS):
        libraries[compiler] = folder / f"{compiler}.so"
        command = [compiler, *FLAGS, "-o", str(libraries[compiler]), str(SOURCE), "-lm"]
        subprocess.run(command, check=True)
    if not libraries:
        raise SystemExit(f"world_against_c: expected one of {', '.join(COMPILERS)}; install one")
    return libraries


def compared(library: Path) -> dict[str, int]:
    """Counts of what differs between ours and C after the same steps from the same state.

    Raises:
        SystemExit: more than rounding.
    """
    ours = COMPARED.simulation()
    rival = Rival(library, ours)
    advances = advancing(ours), rival.advancing()
    found = {"values": 0, "off_by_one": 0, "off_by_more": 0, "contacts": 0}
    for actions in actions_of("random", COMPARED_STEPS, COMPARED.agents):
        for advance in advances:
            advance(actions)
        off = np.abs(ours.stacks.reshape(rival.stack.shape).astype(int) - rival.stack)
        found["values"] += off.size
        found["off_by_one"] += int((off == 1).sum())
        found["off_by_more"] += int((off > 1).sum())
    found["contacts"] = int(ours.contacts.sum())
    found["contacts_differ"] = int((ours.contacts != rival.state["contacts"]).sum())
    found["places_differ"] = int((np.abs(ours.x_m - rival.x_m) > 1e-6).sum())
    _require_equal(found)
    return found


def raced(libraries: dict[str, Path], policy: str, mode: str) -> dict[str, Any]:
    """Million agent-steps a second of ours and of each C; ratios to the faster C."""
    scene = Scene(agents=1024)
    ours = scene.simulation()
    for actions in actions_of(policy, WARM_UP_STEPS, scene.agents):
        ours.step(actions)
    rivals = {name: Rival(path, ours) for name, path in libraries.items()}
    ways = {name: rival.advancing(MODES[mode]) for name, rival in rivals.items()}
    actions = actions_of(policy, STEPS, scene.agents)
    times = rounds_s({"ours": advancing(ours, MODES[mode]), **ways}, actions, ROUNDS)
    best = {name: actions.size / float(seconds.min()) / 1e6 for name, seconds in times.items()}
    fastest = min(rivals, key=lambda name: float(times[name].min()))
    median = float(np.median(times[fastest] / times["ours"]))
    ratios = {"ratio_best": best["ours"] / best[fastest], "ratio_median": median}
    return {"policy": policy, "mode": mode, **best, **ratios}


def _c_world(simulation: Simulation, tables: tuple[npt.NDArray[Any], ...]) -> CWorld:
    world, eye, agents = simulation.params
    assert agents.state.dtype == AGENT_DTYPE
    assert AGENT_DTYPE.itemsize == 17 * 8, "Agent of world.c has seventeen fields of 8 bytes"
    plane, layer, shape = world.planes[0], world.layers[0, 0], world.shapes[0, 0, 0]
    numbers = [plane[name] for name in ("dt_s", "width_m", "chunk_width_m")]
    numbers += [CHUNK_M, *(plane[name] for name in ("ahead_m", "behind_m", "aside_m"))]
    numbers += [layer["reach_m"], shape["size_low"], shape["size_high"]]
    numbers += [shape["length_low"], shape["length_high"], eye.range_m]
    rooms = [agents.boxes.shape[3], agents.belt_places.shape[3], agents.belt_counts.shape[2]]
    counts = [plane["across"], plane["stream"], *rooms, tables[0].size, eye.rays]
    return CWorld(*numbers, *counts, *map(_address, tables))


def _reciprocal(component: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """1 / component, finite."""
    steep = np.copysign(np.maximum(np.abs(component), STEEPEST), component)
    return (1.0 / steep).astype(np.float32)


def _address(array: npt.NDArray[Any]) -> int:
    return int(array.ctypes.data)


def _pointer(array: npt.NDArray[Any] | Actions) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _require_equal(found: dict[str, int]) -> None:
    rounding = found["off_by_one"] <= MOST_OFF_BY_ONE * found["values"]
    wrong = found["off_by_more"] + found["contacts_differ"] + found["places_differ"]
    if wrong or not rounding:
        raise SystemExit(f"world_against_c: expected equal worlds, got {found}; nothing is timed")


def main() -> None:
    """Compare both, time them in turns, and print what was found."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    as_json = parser.parse_args().json
    set_thread_count(1)
    with tempfile.TemporaryDirectory() as folder:
        libraries = built(Path(folder))
        differences = {name: compared(path) for name, path in libraries.items()}
        policies = ("blind", "random")
        rows = [raced(libraries, policy, mode) for policy in policies for mode in MODES]
    if as_json:
        print(json.dumps({"differences": differences, "million_agent_steps_per_s": rows}))
        return
    print(f"differences: {differences}")
    print("".join(f"{name:>14}" for name in rows[0]))
    for row in rows:
        print("".join(f"{v:14.3f}" if isinstance(v, float) else f"{v:>14}" for v in row.values()))


if __name__ == "__main__":
    main()
