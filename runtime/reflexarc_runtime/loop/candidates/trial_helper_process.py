"""The process that starts trials for a loop that is running: see `trial_helper`.

    python -m reflexarc_runtime.loop.candidates.trial_helper_process

It reads a line for each trial, [path, backend] as JSON, and prints what was found, one JSON object.
"""

import json
import signal
import sys
from dataclasses import asdict
from pathlib import Path

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.trial import Trial


def main() -> None:
    """Try until the pipe is closed."""
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(each, signal.SIG_IGN)  # a signal for the whole group is the loop's to answer
    for line in sys.stdin:
        path, backend = json.loads(line)
        print(json.dumps(_found(Path(path), backend)), flush=True)


def _found(path: Path, backend: str) -> dict[str, object]:
    try:
        with Trial(path, backend) as trial:
            return asdict(trial.finding())
    except PolicyError as error:
        return {"error": str(error)}


if __name__ == "__main__":
    main()
