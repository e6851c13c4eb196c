"""A sensor, a brain and a body in reflexarc, as plain rclpy nodes, and as nodes of dora, in turns.

    python benchmarks/frameworks.py --rclpy /tmp/rclpy --dora /tmp/dora [--rounds 3] [--seconds 3]

The folders are environments with that framework; they are made from the package index if they are
not there. A framework without a folder is left out. In each, three processes: a sensor sends 16
bytes and the time; a brain decides on them by the same small network in NumPy; a body takes the
commands, and stands if it was not told to drive for 100 ms. Printed are

- lateness: the brain's wake-ups against its timer's schedule; of dora, whose timer tells none,
  by how much the time between two of them differs from the period;
- unsteadiness: by how much the time between two commands at the body differs from the period;
- latency: from the sending of a retina to the first command at the body that it led to;
- hung, killed: from a SIGSTOP, a SIGKILL to the sensor until the body stands.

Medians over the rounds. Nothing is asserted.
"""

import argparse
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
import onnx
from three_roles import environments, measures
from three_roles.systems import PATIENCE_S, System, signal_role

from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported  # found by the line above
from support.ros2_robot import free_port

RATES_HZ = (50.0, 1000.0)
VARIANTS = {
    "reflexarc": ("rate", "input"),
    "rclpy": ("timer", "timer, age checked", "arrival"),
    "dora": ("timer", "timer, age checked", "timer, failures heeded", "arrival"),
}
WATCHED_S = 1.0
"""How long the body is watched after the sensor hangs, and after it is killed."""
QUANTILES = (50, 99)


def main() -> None:
    """Measure and print."""
    given = _arguments()
    systems = list(_systems(given))
    runs: dict[tuple[System, float], list[dict[str, float]]] = {}
    for number in range(given.rounds):
        print(f"round {number + 1} of {given.rounds}", file=sys.stderr)
        for rate_hz in given.rates:
            for system in systems:
                runs.setdefault((system, rate_hz), []).append(_run(system, rate_hz, given.seconds))
    rows = [_row(system, rate_hz, found) for (system, rate_hz), found in runs.items()]
    load = " ".join(f"{each:.1f}" for each in os.getloadavg())
    said = {each.python: environments.versions(each.python) for each in systems}
    if given.json:
        print(json.dumps({"rows": rows, "load": load, "versions": [*said.values()]}))
        return
    _print_table(rows)
    print("versions", *said.values(), f"Python {sys.version.split()[0]}", sep="\n  ")
    print("load", load)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rclpy", type=Path, help="environment with rclpy")
    parser.add_argument("--dora", type=Path, help="environment with dora-rs")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--rates", type=float, nargs="+", default=RATES_HZ)
    parser.add_argument("--only", nargs="+", help="words that a framework and variant begin with")
    parser.add_argument("--fifo", type=int, default=0, help="SCHED_FIFO priority of everybody")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _systems(given: argparse.Namespace) -> Iterator[System]:
    pythons = {"reflexarc": Path(sys.executable)}
    for name, packages in (("rclpy", environments.RCLPY), ("dora", environments.DORA)):
        folder = getattr(given, name)
        if folder is not None:
            pythons[name] = environments.prepared(folder.resolve(), packages)
    for framework, python in pythons.items():
        for variant in VARIANTS[framework]:
            words = f"{framework} {variant}"
            if not given.only or any(words.startswith(each) for each in given.only):
                yield System(framework, variant, python, given.fifo)


def _run(system: System, rate_hz: float, seconds: float) -> dict[str, float]:
    """The figures of one run, in milliseconds; without those that there are not."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write_policy(folder, rate_hz)
        with system.started(folder, rate_hz, free_port()) as told:
            _wait_for_commands(system, folder, rate_hz)
            begin_ns = time.monotonic_ns()
            time.sleep(seconds)
            end_ns = time.monotonic_ns()
            hung_ns = signal_role(folder, "sensor", signal.SIGSTOP)
            time.sleep(WATCHED_S)
            awake_ns = signal_role(folder, "sensor", signal.SIGCONT)
            time.sleep(WATCHED_S)
            killed_ns = signal_role(folder, "sensor", signal.SIGKILL)
            time.sleep(WATCHED_S)
            gone_ns = time.monotonic_ns()
            late = _own_lateness(system, told)
        commands = measures.written(np.load(folder / "commands.npy"))
        late = late or _noted_lateness(folder, begin_ns, end_ns, rate_hz)
    taken = measures.between(commands, begin_ns, end_ns)
    return {
        **late,
        **_quantiles("unsteady", measures.unsteadiness_ns(taken, round(1e9 / rate_hz))),
        **_quantiles("latency", measures.latencies_ns(commands, begin_ns, end_ns)),
        "commands a second": len(taken) / seconds,
        **_standstill("hung", commands, hung_ns, awake_ns),
        **_standstill("killed", commands, killed_ns, gone_ns),
    }


def _write_policy(folder: Path, rate_hz: float) -> None:
    """A policy file, and its weights for those who compute it by hand."""
    contract = replace(PolicyContract(), rate_hz=rate_hz, max_input_age_s=0.1)
    policy = exported(contract, seed=5, activation="Relu")
    (folder / "policy.onnx").write_bytes(policy)
    save_network(policy, folder)


def save_network(policy: bytes, folder: Path) -> None:
    """The weights of a policy file of one hidden layer, as a brain reads them."""
    graph = onnx.load_from_string(policy).graph
    found = {each.name: onnx.numpy_helper.to_array(each) for each in graph.initializer}
    w1, b1, w2, b2 = (found[name] for name in ("w1", "b1", "w2", "b2"))
    np.savez(folder / "network.npz", w1=w1, b1=b1, w2=w2, b2=b2)


def _wait_for_commands(system: System, folder: Path, rate_hz: float) -> None:
    """Wait until the body was told to drive for half a second."""
    until_s, enough = time.monotonic() + PATIENCE_S, max(5, round(rate_hz / 2))
    file = folder / "commands.npy"
    while time.monotonic() < until_s:
        time.sleep(0.1)
        if file.exists() and file.stat().st_size > 1000:
            rows = np.load(file, mmap_mode="r")
            if np.count_nonzero(rows[: 4 * enough, 2]) >= enough:
                time.sleep(0.5)
                return
    said = "".join(file.read_text()[-500:] for file in sorted(folder.glob("said-*.txt")))
    what = f"{system.framework} {system.variant} at {rate_hz:g} Hz"
    raise SystemExit(f"{what}: expected {enough} drive commands within {PATIENCE_S:g} s: {said}")


def _own_lateness(system: System, told: subprocess.Popen[str]) -> dict[str, float]:
    """What `reflexarc run` says of itself, over the whole run."""
    if system.framework != "reflexarc" or system.variant != "rate":
        return {}
    told.send_signal(signal.SIGINT)
    said, _ = told.communicate(timeout=PATIENCE_S)
    spread = json.loads(said.splitlines()[-1])["phases"]["lateness"]
    return {f"late p{q}": spread[f"p{q}_ns"] * 1e-6 for q in QUANTILES}


def _noted_lateness(folder: Path, begin_ns: int, end_ns: int, rate_hz: float) -> dict[str, float]:
    """What a brain wrote down at its timer."""
    file = folder / "wakes.npy"
    if not file.exists():
        return {}
    wakes = measures.between(measures.written(np.load(file)), begin_ns, end_ns)
    if not len(wakes):
        return {}
    told = bool((wakes[:, 1] >= 0).all())
    late = wakes[:, 1] if told else measures.unsteadiness_ns(wakes, round(1e9 / rate_hz))
    return _quantiles("late", late)


def _quantiles(name: str, times_ns: measures.Rows) -> dict[str, float]:
    if not len(times_ns):
        return {}
    return {f"{name} p{q}": float(np.percentile(times_ns, q)) * 1e-6 for q in QUANTILES}


def _standstill(name: str, commands: measures.Rows, begin: int, until: int) -> dict[str, float]:
    after_ns = measures.standstill_ns(commands, begin, until)
    return {} if after_ns is None else {name: after_ns * 1e-6}


def _row(system: System, rate_hz: float, runs: list[dict[str, float]]) -> dict[str, Any]:
    """Medians over the rounds, in milliseconds; None where a round had none."""
    names = dict.fromkeys(name for run in runs for name in run)
    row = {
        name: statistics.median(run[name] for run in runs)
        if all(name in run for run in runs)
        else None
        for name in names
    }
    return {"hz": rate_hz, "framework": system.framework, "variant": system.variant, **row}


def _print_table(rows: list[dict[str, Any]]) -> None:
    print("| Hz | | brain | lateness, ms | unsteadiness, ms | latency, ms | a second", end="")
    print(" | hung, ms | killed, ms |")
    print("|---|---|---|---|---|---|---|---|---|")
    for row in rows:
        pairs = [_pair(row, name) for name in ("late", "unsteady", "latency")]
        ends = [_end(row.get(name)) for name in ("hung", "killed")]
        words = [f"{row['hz']:g}", row["framework"], row["variant"], *pairs]
        print("|", " | ".join([*words, f"{row['commands a second']:.1f}", *ends]), "|")


def _pair(row: dict[str, Any], name: str) -> str:
    values = [row.get(f"{name} p{q}") for q in QUANTILES]
    return "–" if None in values else ", ".join(f"{value:.2f}" for value in values)


def _end(after_ms: float | None) -> str:
    return "drives on" if after_ms is None else f"{after_ms:.0f}"


if __name__ == "__main__":
    main()
