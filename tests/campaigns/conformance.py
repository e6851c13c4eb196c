"""The files of the MCAP conformance suite through `info`, `replay`, `recover` and `play`.

    python tests/campaigns/conformance.py FOLDER

FOLDER is `tests/conformance/data` of foxglove/mcap: folders of .json files, from which the .mcap
files are built anew, compared with the SHA-256 in the suite's own pointers where they are there. No
traceback; none is called damaged; `recover` keeps every record, compared one by one.
"""

import argparse
import contextlib
import io
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.records import DataEnd, McapRecord, MessageIndex
from mcap.stream_reader import StreamReader

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc.main import main as reflexarc
from support.conformance_files import build, is_the_suites, records_of


@dataclass(frozen=True)
class Said:
    """How a command ended."""

    status: int
    everything: str


def main() -> int:
    """Try them all; one line for each fault, and a sum."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path, help="tests/conformance/data of foxglove/mcap")
    files = sorted(parser.parse_args().folder.glob("**/*.json"))
    faults = proven = 0
    statuses: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        for file in files:
            records, features = records_of(file)
            path = Path(scratch) / f"{file.stem}.mcap"
            path.write_bytes(build(records, features))
            pointer = file.with_suffix(".mcap")
            proven += pointer.exists() and is_the_suites(path.read_bytes(), pointer)
            for fault in _tried(path, records, statuses):
                faults += 1
                print(f"{file.stem}: {fault}", flush=True)
            path.unlink()
    print(f"{len(files)} files, {proven} of them the suite's to the byte; {faults} faults")
    print(", ".join(f"{count} × {what}" for what, count in sorted(statuses.items())))
    return 1 if faults or not files else 0


def _tried(path: Path, records: list[McapRecord], statuses: Counter[str]) -> Iterator[str]:
    """What goes wrong with one file."""
    saved = path.with_name("saved.mcap")
    for words in (["info", path], ["replay", path], ["play", path], ["recover", path, "-o", saved]):
        try:
            said = _said([str(word) for word in words])
        except Exception as error:
            yield f"{words[0]}: {error!r}"
            continue
        statuses[f"{words[0]} with status {said.status}"] += 1
        if "amaged" in said.everything:
            yield f"{words[0]}: called damaged"
        if words[0] in ("replay", "play") and "another system" not in said.everything:
            yield f"{words[0]}: {said.everything.strip()}"
    yield from _compared(records, path, saved)


def _said(words: list[str]) -> Said:
    heard = io.StringIO()
    with contextlib.redirect_stdout(heard), contextlib.redirect_stderr(heard):
        return Said(reflexarc(words), heard.getvalue())


def _compared(records: list[McapRecord], path: Path, saved: Path) -> Iterator[str]:
    wanted = _data_of(iter(records))
    if not saved.exists():
        yield "recover: nothing was written"
        return
    for name, file in (("the file", path), ("recover", saved)):
        with file.open("rb") as opened:
            got = _data_of(StreamReader(opened, validate_crcs=True).records)
        if got != wanted:
            yield f"{name}: {len(got)} records, not the {len(wanted)} of the suite"
    saved.unlink()


def _data_of(records: Iterator[McapRecord]) -> list[McapRecord]:
    """The records of the data section, without the indexes of messages, which are made anew."""
    data = []
    for record in records:
        if isinstance(record, DataEnd):
            break
        if not isinstance(record, MessageIndex):
            data.append(record)
    return data


if __name__ == "__main__":
    sys.exit(main())
