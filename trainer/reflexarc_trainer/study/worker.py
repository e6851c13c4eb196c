"""A process that does units: `python -m reflexarc_trainer.study.worker`.

Standard input: one unit as JSON a line. Standard output: first `{"ready": code}`, then for each
unit `{"result": …}`, or `{"error": "…"}` for one that cannot be done. It computes on one thread,
and ends at the end of its input at once, whatever it is doing: so it does not outlive whoever
started it, however that one ended.
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
    """Do units until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all; the parent decides
    answers = _take_standard_output()
    _compute_on_one_thread()
    _answer(answers, {"ready": code_key()})
    for line in _lines_until_the_end():
        _answer(answers, _done(line))


def _take_standard_output() -> TextIO:
    """The stream of answers; what anything else prints goes to standard error."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    return answers


def _compute_on_one_thread() -> None:
    """Processes share the processors, not threads."""
    set_thread_count(1)
    torch.set_num_threads(1)


def _lines_until_the_end() -> Iterator[str]:
    """Lines of the input; a thread of their own reads them, and notices the end amid the work."""
    lines: SimpleQueue[str] = SimpleQueue()

    def read() -> None:
        for line in sys.stdin:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield lines.get()


def _done(line: str) -> dict[str, Any]:
    try:
        return {"result": dataclasses.asdict(measure(Unit.from_plain(json.loads(line))))}
    except ReflexarcError as error:
        return {"error": str(error)}


def _answer(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
