"""The callback by which the judge measures and stops a run of Stable-Baselines3."""

from stable_baselines3.common.callbacks import BaseCallback

from learning_race.contenders import Theirs
from learning_race.frozen import of_theirs
from learning_race.judge import Judge


class Looks(BaseCallback):
    """Looks at the policy when the judge says so, and ends the run."""

    def __init__(self, judge: Judge, theirs: Theirs) -> None:
        """Call `judge` after every step of the worlds."""
        super().__init__()
        self._judge, self._theirs = judge, theirs

    def _on_step(self) -> bool:
        """Look if it is time; returns whether the run continues."""
        if self._judge.is_due:
            steps = self.model.num_timesteps * self._theirs.held_steps
            self._judge.look(lambda: of_theirs(self.model, self._theirs.input_power), steps)
        return not self._judge.is_over
