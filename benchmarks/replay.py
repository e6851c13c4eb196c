"""How fast is replay, and what does it hold? Against a bare loop over the MCAP library's reader.

    python benchmarks/replay.py [--ticks 180000] [--rounds 5] [--json]
    python benchmarks/replay.py --hours 10 --memory [--log drive.mcap]

The rival decodes each tick and each retina and does nothing with them. Of its readers the one that
reads from front to back is the faster one. Processor time, in turns, medians; the log is that of
the real node: 180,000 ticks are an hour at 50 Hz. Nothing is asserted.

With `--memory`: the most that `reflexarc replay` holds of a log of a tenth of that length, and of
the whole one: at each level, and with a candidate that prefers something else at most ticks. Each
in a process of its own, by the kernel's account of it. The same seven minutes are seen again and
again; ten hours take some minutes to write. With `--log`, of that log instead.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.reader import NonSeekingReader, make_reader

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.messages_pb2 import Tick
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT, drive, nominal, retina_at, smooth_retinas

DECODED = {"/robot0/tick": Tick, "/robot0/retina": RawImage}
RIVAL = "bare loop, from front to back"
TICKS_AN_HOUR = 180_000
SEEN_AGAIN = 20_000
"""After so many retinas of a long log the first one comes again."""
REPLAYED = """
import sys
import time
from pathlib import Path
from reflexarc.main import main
status = main(sys.argv[1:])
held = next(line for line in Path("/proc/self/status").read_text().splitlines() if "VmHWM" in line)
print(f"status {status} held {held.split()[1]} took {time.process_time()}")
"""


class Repeated(Mapping[int, Iterable[Message]]):
    """One retina a slot, made when it is asked for: what is seen comes again and again."""

    def __init__(self, ticks: int) -> None:
        self._retinas, self._ticks = smooth_retinas(SEEN_AGAIN), ticks

    def __getitem__(self, slot: int) -> Iterable[Message]:
        if not 1 <= slot <= self._ticks:
            raise KeyError(slot)
        return [retina_at(slot, self._retinas[(slot - 1) % SEEN_AGAIN])]

    def __iter__(self) -> Iterator[int]:
        return iter(range(1, self._ticks + 1))

    def __len__(self) -> int:
        return self._ticks


def main() -> None:
    """Record, replay in turns, print."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as folder:
        if arguments.memory:
            _print_memory(Path(folder), arguments.hours, arguments.log)
            return
        path = Path(folder) / "run.mcap"
        ticks = arguments.ticks or round(arguments.hours * TICKS_AN_HOUR)
        drive(path, exported(CONTRACT), nominal(ticks), ticks)
        seconds = _seconds(path, arguments.rounds)
    _print_seconds(ticks, seconds, as_json=arguments.json)


def _print_seconds(ticks: int, seconds: dict[str, float], *, as_json: bool) -> None:
    if as_json:
        print(json.dumps({"ticks": ticks, **seconds}))
        return
    print(f"{ticks} ticks")
    for name, taken_s in seconds.items():
        rate, ratio = ticks / taken_s, seconds[RIVAL] / taken_s
        print(f"{name:<34}{taken_s:>8.2f} s{rate:>12,.0f} ticks a second{ratio:>7.2f} of the rival")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ticks", type=int, default=0, help="20,000 by default")
    parser.add_argument("--hours", type=float, default=1 / 9, help="ticks, in hours at 50 Hz")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--memory", action="store_true", help="what replay holds at most")
    parser.add_argument("--log", type=Path, help="with --memory: of this log")
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


def _print_memory(folder: Path, hours: float, given: Path | None) -> None:
    """What each kind of replay holds, of each log."""
    candidate = folder / "candidate.onnx"
    candidate.write_bytes(exported(CONTRACT, seed=1))
    print(f"{'log':<34}{'MB on disk':>12}  {'replay':<34}{'held, MB':>9}{'took, s':>9}")
    for name, path in [("", given)] if given else _long_logs(folder, hours):
        size = f"{path.stat().st_size / 1e6:>12.1f}"
        for flags in (("--level", "policy"), ("--level", "node"), ("--policy", candidate)):
            held_mb, took_s = _held(path, flags)
            said = " ".join(str(getattr(word, "name", word)) for word in flags)
            row = f"{name or path.name:<34}{size}  {said:<34}{held_mb:>9.0f}{took_s:>9.1f}"
            print(row, flush=True)


def _long_logs(folder: Path, hours: float) -> Iterator[tuple[str, Path]]:
    for length in (hours / 10, hours):
        path, ticks = folder / "run.mcap", round(length * TICKS_AN_HOUR)
        drive(path, exported(CONTRACT), Repeated(ticks), ticks)
        yield f"{length:g} h, {ticks} ticks", path
        path.unlink()


def _held(path: Path, flags: Iterable[object]) -> tuple[float, float]:
    """The most memory, and the processor time.

    The kernel's account of a process of its own: `ru_maxrss` would be that of the one that started
    it, if that held more.
    """
    words = [sys.executable, "-c", REPLAYED, "replay", path, *flags]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True)
    said = dict(zip(*[iter(done.stdout.splitlines()[-1].split())] * 2, strict=True))
    if said["status"] == "2":
        raise SystemExit(f"not replayed: {done.stderr}")
    return int(said["held"]) * 1024 / 1e6, float(said["took"])


if __name__ == "__main__":
    main()
