"""Each incident of real drives becomes a log of its own, which shows it and replays by itself.

    python tests/campaigns/incidents.py [LOG…] [--most 100] [--keep FOLDER]

Without logs it drives: a policy learns, and eight drives follow with contacts, guards, stops,
overruns and marks, half of them in real time, with faults and an operator (five minutes).

Cuts incidents out of the logs, of each kind in turn, narrowly and with two seconds around it, and
replays each part at both levels. The status is 1 if a part does not show its incident, or is not
identical.
"""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import chain, islice, zip_longest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.cutting.incident_part import cut_incident
from reflexarc_logs.reading.incidents import Incident, find_incidents
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import Log, read_log
from support.incident_drives import make_drives
from support.processes import reflexarc


def main() -> int:
    """Drive, cut, replay, count."""
    given = _arguments()
    with tempfile.TemporaryDirectory() as name:
        logs = log_paths(given.logs) if given.logs else _driven(given.keep or Path(name))
        return _judge(logs, given.most)


def _judge(logs: Iterable[Path], most: int) -> int:
    found: dict[str, list[tuple[Log, Incident]]] = {}
    for log in map(read_log, logs):
        incidents = list(find_incidents(log))
        print(f"{log.path.name}: {dict(Counter(one.kind for one in incidents))}", flush=True)
        for incident in incidents:
            found.setdefault(incident.kind, []).append((log, incident))
    good: Counter[str] = Counter()
    bad: list[str] = []
    for log, incident in islice(_in_turn(found), most):
        fault = _fault(log, incident)
        good[incident.kind] += not fault
        bad += [f"{log.path.name}, {incident}: {fault}"] * bool(fault)
    for line in bad:
        print(line)
    total = good.total() + len(bad)
    print(f"{total} incidents: {dict(good)} replay by themselves, {len(bad)} do not")
    return int(bool(bad))


def _driven(folder: Path) -> Iterator[Path]:
    """Drives of a policy that learned for it."""
    folder.mkdir(parents=True, exist_ok=True)
    done = reflexarc("train", "--out", folder / "learned")
    if done.returncode:
        raise SystemExit(done.stderr)
    yield from make_drives(folder / "learned" / "policy.onnx", folder)


def _in_turn(found: dict[str, list[tuple[Log, Incident]]]) -> Iterator[tuple[Log, Incident]]:
    """One of each kind, as long as there is one."""
    rounds = zip_longest(*found.values())
    return (one for one in chain.from_iterable(rounds) if one is not None)


def _fault(log: Log, incident: Incident) -> str:
    """What is wrong with its parts; empty: nothing."""
    with tempfile.TemporaryDirectory() as folder:
        for narrow in (True, False):
            found = cut_incident(log, incident, 2.0, Path(folder) / f"{narrow}.mcap", narrow=narrow)
            if not found.is_shown:
                return "the part does not show it"
            if found.report.exit_status or len(found.report.levels) != 2:
                return "; ".join(found.report.lines())
    return ""


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("logs", type=Path, nargs="*", help="logs and folders of them")
    parser.add_argument("--most", type=int, default=100)
    parser.add_argument("--keep", type=Path, help="without logs: leave the drives here")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
