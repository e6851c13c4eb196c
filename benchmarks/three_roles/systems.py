"""Starts a sensor, a brain and a body in one framework, and ends them."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
SHARED = Path("/dev/shm")
"""Where Fast DDS leaves its segments when a process is killed."""
PATIENCE_S = 60.0


@dataclass(frozen=True)
class System:
    """Three roles in one framework.

    Attributes:
        framework: `reflexarc`, `rclpy` or `dora`.
        variant: what the brain does; see the framework's module.
        python: interpreter of the framework's environment.
        fifo: SCHED_FIFO priority of all processes; 0: ordinary scheduling.
    """

    framework: str
    variant: str
    python: Path
    fifo: int = 0

    @contextmanager
    def started(self, folder: Path, rate_hz: float, port: int) -> Iterator[subprocess.Popen[str]]:
        """Run the roles with a folder of their own; gives what the brain, or dora, prints."""
        orders = self._orders(folder, rate_hz, port)
        with _processes(orders, folder, self.fifo, self._surroundings()) as processes:
            yield processes[min(1, len(processes) - 1)]

    def _orders(self, folder: Path, rate_hz: float, port: int) -> list[list[str]]:
        """What to start, the brain second."""
        role = HERE / f"{self.framework}_node.py"
        words = ["--folder", str(folder), "--rate-hz", str(rate_hz), "--variant", self.variant]
        if self.framework == "dora":
            flow = folder / "dataflow.json"
            flow.write_text(json.dumps(_dataflow(role, words, rate_hz)))
            return [[str(self.python.parent / "dora"), "run", str(flow)]]
        start = [str(self.python), str(role)]
        words += ["--port", str(port)]
        orders = [[*start, name, *words] for name in ("body", "brain", "sensor")]
        if self.framework == "reflexarc":
            orders[1] = [*_run(folder, port), "--pace", self.variant]
        return orders

    def _surroundings(self) -> dict[str, str]:
        surroundings = dict(os.environ)
        if self.framework != "reflexarc":
            surroundings.pop("PYTHONPATH", None)
            surroundings["PATH"] = f"{self.python.parent}:{surroundings['PATH']}"
        if self.framework == "rclpy":
            surroundings["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
            surroundings["ROS_DOMAIN_ID"] = str(random.randrange(1, 100))
            surroundings["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
        return surroundings


def _run(folder: Path, port: int) -> list[str]:
    policy = str(folder / "policy.onnx")
    run = [sys.executable, "-m", "reflexarc", "run", policy, "--port", str(port)]
    return [*run, "--allow-fast", "--json"]


def _dataflow(role: Path, words: list[str], rate_hz: float) -> dict[str, object]:
    """The graph, as JSON, which is YAML too. The brain takes the newest retina only."""

    def node(name: str, outputs: list[str], inputs: dict[str, object]) -> dict[str, object]:
        arguments = " ".join([name, *words[:-1], f"'{words[-1]}'"])
        return {
            "id": name,
            "path": str(role),
            "args": arguments,
            "outputs": outputs,
            "inputs": inputs,
        }

    retina: dict[str, object] = {"retina": {"source": "sensor/retina", "queue_size": 1}}
    if words[-1].startswith("timer"):
        retina["tick"] = f"dora/timer/millis/{round(1000 / rate_hz)}"
    return {
        "nodes": [
            node("sensor", ["retina"], {}),
            node("brain", ["command"], retina),
            node("body", [], {"command": "brain/command"}),
        ]
    }


@contextmanager
def _processes(
    orders: list[list[str]], folder: Path, fifo: int, surroundings: dict[str, str]
) -> Iterator[list[subprocess.Popen[str]]]:
    first = ["chrt", "-f", str(fifo)] if fifo else []
    processes: list[subprocess.Popen[str]] = []
    segments = set(SHARED.glob("*fastdds_*"))
    try:
        for order in orders:
            with (folder / f"said-{len(processes)}.txt").open("w") as said:
                told = subprocess.PIPE if len(processes) == 1 else said
                processes.append(
                    subprocess.Popen(
                        [*first, *order],
                        stdout=told,
                        stderr=said,
                        text=True,
                        cwd=folder,
                        env=surroundings,
                    )
                )
        yield processes
    finally:
        for role in ("sensor", "brain", "body"):
            signal_role(folder, role, signal.SIGKILL)
        for process in processes:
            process.kill()
            process.communicate()
        for segment in set(SHARED.glob("*fastdds_*")) - segments:
            segment.unlink(missing_ok=True)


def signal_role(folder: Path, role: str, number: signal.Signals) -> int:
    """Send a signal to a role's process; when it was sent."""
    file = folder / f"{role}.pid"
    now_ns = time.monotonic_ns()
    with suppress(ProcessLookupError):
        if file.exists():
            os.kill(int(file.read_text()), number)
    return now_ns
