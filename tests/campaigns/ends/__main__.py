"""Whatever ends a drive, how soon is the robot told to stand, and how far does it roll?

    python tests/campaigns/ends [--ends 1000] [--seed 1] [--parallel N] [--only WORD] [--json]
                                [--keep FOLDER]

Real processes that drive real robots of two kinds (`kinds.py`) are killed, stopped, hung up, and
made to hang, at random moments. Robots live on; only what ended is started again. What a robot that
holds its last twist for ever, and one with a time-out of 0.5 s, did after that is computed from its
twists (tests/support/ros2_base.py), for 1 m/s and brakes of 2 m/s²: by itself that takes 500 ms and
250 mm. A bound that was missed counts as the machine's only as far as a witness overslept, too.
Every log is replayed, a `.partial` after its recovery. Exit status 1: something that must never be.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # the tests' packages

from campaigns.ends.campaign import run
from campaigns.ends.table import summary, table


def main() -> int:
    """Run it and print a table, or one JSON object."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (arguments.keep or Path(temporary)).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise SystemExit(f"--keep: {folder}: expected an empty folder; choose another one")
        campaign = run(arguments.ends, arguments.seed, arguments.parallel, arguments.only, folder)
    report = summary(campaign)
    print(json.dumps(report) if arguments.json else table(report))
    return 1 if report["failures"] else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--ends", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--parallel", type=int, default=2 * (os.cpu_count() or 1), help="robots at once"
    )
    parser.add_argument("--only", default="", help="ends with this word in their name")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--keep", type=Path, help="keep the logs here")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
