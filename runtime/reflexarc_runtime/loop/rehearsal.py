"""Does the last tick again just before the next one, and throws it away: the caches are warm then.

Between two ticks the processor's caches fill with what others do, so that at 50 Hz a decision takes
several times as long as in a tight loop. `controller.step` is pure: doing it once more changes
nothing, and what the next tick needs lies near when its input comes. It happens before the
deadline, or before the next input is expected, in time that the loop sleeps through anyway: once in
good time, when it takes as long as a cold tick does, and once again shortly before, where that one
may be forgotten already.
"""

from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.messages.codec import encode_command
from reflexarc_runtime.serving.swapping import AnyController


class Rehearsal:
    """Knows the last tick, and does it again.

    Args:
        controller: of the loop.
    """

    def __init__(self, controller: AnyController) -> None:
        self._controller = controller
        self._last: tuple[State, Inputs, int] | None = None
        self.tick_ns: int | None = None
        """How long the tick that it does again took to decide; None: there is none yet."""

    def note(self, before: State, inputs: Inputs, now_ns: int, decide_ns: int) -> None:
        """A tick was made of this; one with a message does more than one without."""
        if inputs.messages or self._last is None:
            self._last, self.tick_ns = (before, inputs, now_ns), decide_ns

    def __call__(self) -> None:
        """Do it again; nothing comes of it."""
        if self._last is None:
            return
        try:
            _, decision = self._controller.step(*self._last)
        except DecisionEndedError:  # by the watchdog: the tick itself will be told
            return
        encode_command(decision.command)
