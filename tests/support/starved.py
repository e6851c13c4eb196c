"""How long threads of a process were ready and got no processor, by the kernel's account."""

import time
from collections import deque
from pathlib import Path

WINDOW_S = 2.0


class Starved:
    """The last seconds of a process.

    Args:
        pid: whose threads they are.
    """

    def __init__(self, pid: int) -> None:
        self._tasks = Path(f"/proc/{pid}/task")
        self._looks: deque[tuple[float, dict[str, int]]] = deque()

    def look(self) -> None:
        """Take note; often."""
        now_s = time.monotonic()
        self._looks.append((now_s, self._waited_ns()))
        while now_s - self._looks[0][0] > WINDOW_S:
            self._looks.popleft()

    @property
    def worst_s(self) -> float:
        """Of the thread that waited longest, in the last two seconds."""
        if not self._looks:
            return 0.0
        before, now = self._looks[0][1], self._looks[-1][1]
        return max((ns - before.get(name, 0) for name, ns in now.items()), default=0) * 1e-9

    def _waited_ns(self) -> dict[str, int]:
        found = {}
        for task in self._tasks.glob("*/schedstat"):
            try:
                found[task.parent.name] = int(task.read_text().split()[1])
            except OSError:
                continue  # it ended just now
        return found
