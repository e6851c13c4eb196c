"""How fast is diff? Against the MCAP library's reader, which reads both files and compares nothing.

One row only reads, the other one decodes as well, with the library's own decoder for protobuf.

    python benchmarks/diff.py [--ticks 20000] [--rounds 5]

Two drives with the same inputs, and a third one by another policy, so that many fields differ. Each
figure is the median over the rounds, in which the programs take turns.
"""

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from reflexarc_logs.diffing.diff import diff
from support.policies import exported
from support.recordings import CONTRACT, drive, nominal


def main() -> None:
    """Record, compare in turns, print."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as folder:
        logs = _recorded(Path(folder), arguments.ticks)
        trials: dict[str, Callable[[], object]] = {
            "reference reader, both files": lambda: [_read(path) for path in logs[:2]],
            "the same, decoded": lambda: [_decode(path) for path in logs[:2]],
            "diff, the same decisions": lambda: diff(logs[0], logs[1]),
            "diff, another policy's decisions": lambda: diff(logs[0], logs[2]),
        }
        seconds = {name: [] for name in trials}
        for _ in range(arguments.rounds):
            for name, trial in trials.items():
                began_s = time.process_time()
                trial()
                seconds[name].append(time.process_time() - began_s)
    reference_s = statistics.median(seconds["reference reader, both files"])
    for name, taken in seconds.items():
        median_s = statistics.median(taken)
        print(f"{name:<36}{median_s:>8.3f} s  {median_s / reference_s:>5.2f} of the reader")


def _recorded(folder: Path, ticks: int) -> list[Path]:
    paths = []
    for name, seed in (("a", 5), ("b", 5), ("c", 6)):
        path = folder / f"{name}.mcap"
        drive(path, exported(CONTRACT, seed=seed), nominal(ticks), ticks)
        paths.append(path)
    return paths


def _read(path: Path) -> int:
    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file).iter_messages())


def _decode(path: Path) -> int:
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return sum(1 for _ in reader.iter_decoded_messages())


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ticks", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=5)
    return parser.parse_args()


if __name__ == "__main__":
    main()
