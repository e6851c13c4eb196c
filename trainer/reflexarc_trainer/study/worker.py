"""A worker process, which does units of a study: `python -m reflexarc_trainer.study.worker`.

Standard input has one unit per line, as JSON. Standard output has first `{"ready": code}`, then for
each unit `{"result": …}`, or `{"error": "…"}` if it cannot be done. The process computes on one
thread. It exits immediately at the end of its input, even while it is learning, and so never
outlives the process that started it.
"""

import dataclasses
import json
import os
import signal
import sys
import threading
from collections.abc import Iterator
from queue import SimpleQueue
from typing import Any, TextIO

import torch

from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_trainer.study.measuring import measure
from reflexarc_trainer.study.unit import Unit, code_key


def main() -> None:
    """Do units until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it too; its parent ends it
    answers = _take_standard_output()
    _compute_on_one_thread()
    _answer(answers, {"ready": code_key()})
    for line in _lines_until_the_end():
        _answer(answers, _answer_to(line))


def _take_standard_output() -> TextIO:
    """A stream for the answers; from now on, standard output goes to standard error."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    return answers


def _compute_on_one_thread() -> None:
    """Compute on one thread: there is one worker per processor."""
    set_thread_count(1)
    torch.set_num_threads(1)


def _lines_until_the_end() -> Iterator[str]:
    """Lines of the input, read by a thread that exits the process at the end of the input."""
    lines: SimpleQueue[str] = SimpleQueue()

    def read() -> None:
        for line in sys.stdin:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield lines.get()


def _answer_to(line: str) -> dict[str, Any]:
    try:
        return {"result": dataclasses.asdict(measure(Unit.from_plain(json.loads(line))))}
    except ReflexarcError as error:
        return {"error": str(error)}


def _answer(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
