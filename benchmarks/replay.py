"""How fast is replay? Both levels, against a bare loop over the MCAP library's reader.

    python benchmarks/replay.py [--ticks 180000] [--rounds 5] [--json]

The rival decodes each tick and each retina and does nothing with them. Of its readers the one that
reads from front to back is the faster one. Processor time, in turns, medians; the log is that of
the real node: 180,000 ticks are an hour at 50 Hz. Nothing is asserted.
"""

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.reader import NonSeekingReader, make_reader

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.messages_pb2 import Tick
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT, drive, nominal

DECODED = {"/robot0/tick": Tick, "/robot0/retina": RawImage}
RIVAL = "bare loop, from front to back"


def main() -> None:
    """Record, replay in turns, print."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        drive(path, exported(CONTRACT), nominal(arguments.ticks), arguments.ticks)
        seconds = _seconds(path, arguments.rounds)
    rival_s = seconds[RIVAL]
    if arguments.json:
        print(json.dumps({"ticks": arguments.ticks, **seconds}))
        return
    print(f"{arguments.ticks} ticks")
    for name, taken_s in seconds.items():
        rate, ratio = arguments.ticks / taken_s, rival_s / taken_s
        print(f"{name:<34}{taken_s:>8.2f} s{rate:>12,.0f} ticks a second{ratio:>7.2f} of the rival")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ticks", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _seconds(path: Path, rounds: int) -> dict[str, float]:
    """Medians of the processor time that each takes."""
    trials: dict[str, Callable[[], object]] = {
        RIVAL: lambda: _bare(path, NonSeekingReader),
        "bare loop, in the order of time": lambda: _bare(path, make_reader),
        "open and check": lambda: read_log(path),
        "level policy": lambda: replay(path, level="policy"),
        "level node": lambda: replay(path, level="node"),
    }
    taken_s: dict[str, list[float]] = {name: [] for name in trials}
    for _ in range(rounds):
        for name, trial in trials.items():
            began_s = time.process_time()
            trial()
            taken_s[name].append(time.process_time() - began_s)
    return {name: statistics.median(one) for name, one in taken_s.items()}


def _bare(path: Path, reader: Callable) -> None:
    with path.open("rb") as file:
        for _, channel, message in reader(file).iter_messages():
            kind = DECODED.get(channel.topic)
            if kind is not None:
                kind.FromString(message.data)


if __name__ == "__main__":
    main()
