"""The inside of a worker process: it reads tasks, does them, and answers.

Standard input has one task per line, as JSON. Standard output has first `{"ready": …}`, then for
each task `{"result": …}`, or `{"error": "…"}` if it cannot be done. It exits immediately at the
end of its input, even amid its work, and so never outlives the process that started it.
"""

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from queue import SimpleQueue
from typing import Any, TextIO

from reflexarc_runtime.errors import ReflexarcError

Doing = Callable[[dict[str, Any]], dict[str, Any]]


def serve(do: Doing, ready: str) -> None:
    """Do tasks until the input ends.

    Args:
        do: does one; what it raises as a `ReflexarcError` is why that task cannot be done, and any
            other error ends the process.
        ready: said once before the first task.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it too; its parent ends it
    answers = _take_standard_output()
    _answer(answers, {"ready": ready})
    for line in _lines_until_the_end():
        _answer(answers, _answer_to(line, do))


def _take_standard_output() -> TextIO:
    """A stream for the answers; from now on, standard output goes to standard error."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    return answers


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


def _answer_to(line: str, do: Doing) -> dict[str, Any]:
    try:
        return {"result": do(json.loads(line))}
    except ReflexarcError as error:
        return {"error": str(error)}


def _answer(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()
