"""Do the golden logs replay on Arm with the same bits? `make test-arm` says it.

Makes an emulated aarch64 machine in `.arm/`. It and this machine replay every log below
`tests/golden/`, compute the same networks and evaluate the same functions; then their answers are
compared.
Exit status 0: the same bits; 1: not the same; 2: there is no emulated machine to ask.
"""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))  # the tests' support package

from arm.machine import ROOT, ArmMachine, build_machine  # noqa: E402  # found by the line above
from reflexarc_runtime.errors import ReflexarcError  # noqa: E402
from support.policies import exported  # noqa: E402
from support.recordings import CONTRACT  # noqa: E402

FOLDER = ROOT / ".arm"
ANSWERS = HERE / "answers.py"
CPUS = ("cortex-a72", "max")
"""A Raspberry Pi 4's processor; and all that qemu knows, SVE among it, which other kernels use."""
ACTIVATIONS = ("Tanh", "Sigmoid")
SEEDS = range(16)
RETINAS = 256
SUMS = 200_000
LARGEST_SUM = 20.0
"""Beyond it tanh and sigmoid are 1 in float32; the test networks' own sums stay below it."""


@dataclass(frozen=True)
class Answers:
    """What one machine answered."""

    machine: dict[str, str]
    replays: dict[str, dict[str, tuple[int, str]]]
    """Exit status and report, by log and backend."""
    values: dict[str, npt.NDArray[np.floating]]

    def statuses(self, backend: str) -> dict[str, int]:
        """Exit status of each log's replay."""
        return {log: replays[backend][0] for log, replays in self.replays.items()}


def main() -> int:
    """Ask both machines, and print what they said and where they differ."""
    try:
        machine = build_machine(FOLDER)
        ask_questions(FOLDER / "questions")
        here = answers_here()
        print(f"here: {_line(here.machine)}")
        same = [compare(here, answers_of(machine, cpu), cpu) for cpu in CPUS]
    except ReflexarcError as error:
        print(f"test-arm: {error}", file=sys.stderr)
        return 2
    print("the same bits on Arm" if all(same) else "NOT the same bits on Arm")
    return 0 if all(same) else 1


def ask_questions(folder: Path) -> None:
    """Write the networks and their inputs, so that no machine makes its own."""
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(0)
    shape = (RETINAS, *CONTRACT.retina.stack_shape)
    np.save(folder / "retinas.npy", rng.integers(0, 256, shape, dtype=np.uint8))
    np.save(folder / "sums.npy", rng.uniform(-LARGEST_SUM, LARGEST_SUM, SUMS))
    for activation in ACTIVATIONS:
        for seed in SEEDS:
            file = folder / f"{activation}-{seed}.onnx"
            file.write_bytes(exported(CONTRACT, seed, activation))


def answers_here() -> Answers:
    """This machine's answers, by the same program."""
    subprocess.run([sys.executable, *_arguments("here")], cwd=ROOT, check=True)
    return _read("here")


def answers_of(machine: ArmMachine, cpu: str) -> Answers:
    """The emulated machine's answers."""
    print(f"test-arm: asking {cpu} …", file=sys.stderr)
    machine.run_python(_arguments(cpu), cpu)
    return _read(cpu)


def compare(here: Answers, there: Answers, cpu: str) -> bool:
    """Print what a machine answered; whether it replayed all, with the bits of this machine."""
    print(f"\n{cpu}: {_line(there.machine)}")
    checks = [
        there.machine["machine"] == "aarch64",
        _logs_are_identical(there),
        _onnxruntime_is_as_close(here, there),
        _q_values_are_the_same(here, there),
    ]
    _print_functions(here, there)
    return all(checks)


def _logs_are_identical(there: Answers) -> bool:
    """With the NumPy backend: every report says so."""
    for replays in there.replays.values():
        print(replays["numpy"][1].rstrip())
    statuses = there.statuses("numpy")
    print(f"numpy: {_count(statuses)} of {len(statuses)} logs replayed identically")
    return bool(statuses) and not any(statuses.values())


def _onnxruntime_is_as_close(here: Answers, there: Answers) -> bool:
    """onnxruntime agrees to a tolerance; what misses it on this machine may miss it there too."""
    ours, theirs = here.statuses("onnxruntime"), there.statuses("onnxruntime")
    print(f"onnxruntime: {_count(theirs)} of {len(theirs)} logs replayed within its tolerance")
    for log in (log for log, status in theirs.items() if status):
        print(there.replays[log]["onnxruntime"][1].rstrip())
        print("  as on this machine" if _same_report(here, there, log) else "  NOT as here")
    return all(status in (0, ours[log]) for log, status in theirs.items())


def _same_report(here: Answers, there: Answers, log: str) -> bool:
    return here.replays[log]["onnxruntime"] == there.replays[log]["onnxruntime"]


def _q_values_are_the_same(here: Answers, there: Answers) -> bool:
    names = [name for name in here.values if not name.startswith("function ")]
    count = sum(here.values[name].size for name in names)
    differing = sum(_differing(here.values[name], there.values[name]) for name in names)
    print(f"Q-values: {len(names)} networks, {count} values of float32, {differing} differ")
    return differing == 0


def _print_functions(here: Answers, there: Answers) -> None:
    """How many values differ before and after the one rounding; a fact, not a condition."""
    for name in (name for name in here.values if name.startswith("function ")):
        ours, theirs = here.values[name], there.values[name]
        apart = np.abs(ours.view(np.int64) - theirs.view(np.int64)).max()  # signs are the same
        rounded = _differing(ours.astype(np.float32), theirs.astype(np.float32))
        print(
            f"{name}: of {ours.size} values {_differing(ours, theirs)} differ in float64, by up to "
            f"{apart} units in the last place; once rounded to float32 {rounded} differ"
        )


def _differing(ours: npt.NDArray[np.floating], theirs: npt.NDArray[np.floating]) -> int:
    unsigned = f"u{ours.itemsize}"
    return int((ours.view(unsigned) != theirs.view(unsigned)).sum())


def _arguments(name: str) -> list[str]:
    logs = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("tests/golden/**/*.mcap"))
    return [str(ANSWERS), str(FOLDER / "questions"), str(FOLDER / "answers" / name), *logs]


def _read(name: str) -> Answers:
    folder = FOLDER / "answers" / name
    said = json.loads((folder / "answers.json").read_text(encoding="utf-8"))
    replays = {
        log: {backend: (status, report) for backend, (status, report) in by_backend.items()}
        for log, by_backend in said["replays"].items()
    }
    with np.load(folder / "answers.npz") as values:
        return Answers(said["machine"], replays, dict(values))


def _line(machine: dict[str, str]) -> str:
    return (
        f"{machine['machine']}, Python {machine['python']}, {machine['libc']}, NumPy "
        f"{machine['numpy']} ({machine['simd']}), onnxruntime {machine['onnxruntime']}"
    )


def _count(statuses: dict[str, int]) -> int:
    return sum(status == 0 for status in statuses.values())


if __name__ == "__main__":
    sys.exit(main())
