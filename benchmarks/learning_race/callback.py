"""Where Stable-Baselines3 lets the judge in: after every step of its worlds."""

from stable_baselines3.common.callbacks import BaseCallback

from learning_race.contenders import Theirs
from learning_race.frozen import of_theirs
from learning_race.judge import Judge


class Looks(BaseCallback):
    """Looks when it is time, and ends the run."""

    def __init__(self, judge: Judge, theirs: Theirs) -> None:
        """Look for `judge`."""
        super().__init__()
        self._judge, self._theirs = judge, theirs

    def _on_step(self) -> bool:
        """Whether to go on."""
        if self._judge.is_due:
            steps = self.model.num_timesteps * self._theirs.held_steps
            self._judge.look(lambda: of_theirs(self.model, self._theirs.input_power), steps)
        return not self._judge.is_over
