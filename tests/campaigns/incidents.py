"""Each incident of real drives becomes a log of its own, which shows it and replays by itself.

    python tests/campaigns/incidents.py LOG… [--most 100]

Cuts every incident out of the logs (contacts, guards, stops, overruns, marks), narrowly and with
two seconds around it, and replays each part at both levels. The status is 1 if a part does not show
its incident, or is not identical.
"""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from reflexarc_logs.cutting.incident_part import cut_incident
from reflexarc_logs.reading.incidents import Incident, find_incidents
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import Log, read_log


def main() -> int:
    """Cut, replay, count."""
    given = _arguments()
    good: Counter[str] = Counter()
    bad: list[str] = []
    for log, incident in _all(given.logs):
        if good.total() + len(bad) >= given.most:
            break
        fault = _fault(log, incident)
        good[incident.kind] += not fault
        bad += [f"{log.path.name}, {incident}: {fault}"] * bool(fault)
    for line in bad:
        print(line)
    print(
        f"{good.total() + len(bad)} incidents: {dict(good)} replay by themselves, {len(bad)} do not"
    )
    return int(bool(bad))


def _all(places: list[Path]) -> Iterator[tuple[Log, Incident]]:
    for path in log_paths(places):
        log = read_log(path)
        for incident in find_incidents(log):
            yield log, incident


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
    parser.add_argument("logs", type=Path, nargs="+", help="logs and folders of them")
    parser.add_argument("--most", type=int, default=100)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
