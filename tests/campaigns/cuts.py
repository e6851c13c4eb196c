"""Logs cut at random bytes, and with random bits flipped: what `recover` saves of them.

    python tests/campaigns/cuts.py LOG… [--cuts 2000] [--flips 5000] [--seed 1]

Nothing intact is lost: what stands in a chunk, an attachment or metadata that was not touched is in
the recovered log. Nothing is invented: every message of the recovered log is one of the original.
Nothing is hushed up: with a record missing, the status is not 0. The oracle is the MCAP library's
own reader.
"""

import argparse
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from mcap.records import Attachment, Channel, Chunk, DataEnd, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk

from reflexarc_logs.container.frames import MAGIC
from reflexarc_logs.container.writing import END
from reflexarc_logs.reading.recover import Recovered, recover
from reflexarc_runtime.errors import LogError

Known = tuple[int, int, int, bytes]
"""Sequence, log time, publish time, payload; negative numbers mark what is no message."""


@dataclass(frozen=True)
class Original:
    """A whole log, as the MCAP library reads it."""

    data: bytes
    parts: list[tuple[int, int, Counter[Known]]]
    """Where each begins and ends, and what it holds."""

    @cached_property
    def everything(self) -> Counter[Known]:
        """All that the log holds."""
        return sum((held for _, _, held in self.parts), Counter())


@dataclass(frozen=True)
class Mutant:
    """The bytes of a log with one fault."""

    name: str
    data: bytes
    first: int
    """Offset of the first byte that is not what it was, or is missing."""
    end: int
    """Offset behind the last one."""


def main() -> int:
    """Try all faults on all logs; one line for each that is treated wrongly, and a sum."""
    given = _arguments()
    tried = wrong = 0
    statuses: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for log in given.logs:
            original = read_original(log)
            for mutant in mutants(original.data, given.cuts, given.flips, given.seed):
                fault, status = judged(original, mutant, Path(folder))
                tried, wrong = tried + 1, wrong + bool(fault)
                statuses[status] += 1
                if fault:
                    print(f"{log.name}, {mutant.name}: {fault}", flush=True)
    print(f"{tried} faults, {wrong} treated wrongly; status {dict(sorted(statuses.items()))}")
    return 1 if wrong or not tried else 0


def read_original(path: Path) -> Original:
    """The parts of a whole log that hold something, and what is in them."""
    parts, position = [], len(MAGIC)
    with path.open("rb") as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, DataEnd):
                break
            inside = breakup_chunk(record, True) if isinstance(record, Chunk) else [record]
            parts.append((position, file.tell(), Counter(filter(None, map(_known, inside)))))
            position = file.tell()
    return Original(path.read_bytes(), parts)


def _known(record: McapRecord) -> Known | None:
    """What is compared of a record; of those that only serve others nothing."""
    match record:
        case Message():
            return record.sequence, record.log_time, record.publish_time, record.data
        case Attachment():
            name = f"{record.name}: {record.media_type}".encode()
            return -1, record.log_time, record.create_time, name + record.data
        case Metadata():
            return -2, 0, 0, repr((record.name, sorted(record.metadata.items()))).encode()
    return None


def judged(original: Original, mutant: Mutant, folder: Path) -> tuple[str, str]:
    """What is wrong with the recovery of a mutant, in words; and the status of it."""
    broken, saved = folder / "broken.mcap", folder / "saved.mcap"
    broken.write_bytes(mutant.data)
    saved.unlink(missing_ok=True)
    intact = sum((held for *span, held in original.parts if _spared(mutant, *span)), Counter())
    try:
        recovered = recover(broken, saved)
    except LogError as error:
        return (f"refused, with intact records: {error}" if intact else "", "2")
    return _difference(original, intact, recovered), str(recovered.exit_status)


def _difference(original: Original, intact: Counter[Known], recovered: Recovered) -> str:
    got = Counter(_read(recovered.path))
    certain = Counter({known: n for known, n in got.items() if known[0] >= 0})
    if invented := certain - original.everything:
        return f"{invented.total()} messages invented"
    if lost := intact - got:
        return f"{lost.total()} intact records lost"
    missing = original.everything - got
    if missing and recovered.exit_status == 0:
        return f"{missing.total()} records missing, status 0"
    known = sum(recovered.lost_by_topic.values())
    messages = sum(count for record, count in missing.items() if record[0] >= 0)
    return f"{known} said to be lost, {messages} are" if known > messages else ""


def _read(path: Path) -> Iterator[Known]:
    """What is in a recovered log, by the library; each message must have a channel."""
    channels: set[int] = set()
    with path.open("rb") as file:
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, Channel):
                channels.add(record.id)
            assert not isinstance(record, Message) or record.channel_id in channels
            if (known := _known(record)) is not None and not _is_our_note(record):
                yield known


def _is_our_note(record: McapRecord) -> bool:
    """The record in which `recover` says that something is missing."""
    return isinstance(record, Metadata) and record.name == END


def _spared(mutant: Mutant, start: int, end: int) -> bool:
    return end <= mutant.first or start >= mutant.end


def mutants(data: bytes, cuts: int, flips: int, seed: int) -> Iterator[Mutant]:
    """A log cut, and with bits flipped, at places drawn from the seed."""
    dice = random.Random(seed)
    for _ in range(cuts):
        size = dice.randrange(1, len(data))
        yield Mutant(f"cut at {size}", data[:size], size, len(data))
    for _ in range(flips):
        at, bit = dice.randrange(len(data)), dice.randrange(8)
        changed = bytes([data[at] ^ 1 << bit])
        flipped = data[:at] + changed + data[at + 1 :]
        yield Mutant(f"bit {bit} of byte {at}", flipped, at, at + 1)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("logs", type=Path, nargs="+", help="whole logs, chunked")
    parser.add_argument("--cuts", type=int, default=2000, help="cuts of each log")
    parser.add_argument("--flips", type=int, default=5000, help="flipped bits of each log")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
