"""`reflexarc evaluate`: measures policies, on the reference field or on a suite of worlds."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from reflexarc.terminal.output import aside, console, print_json, progress_bar
from reflexarc.terminal.signals import terminated_as_interrupted
from reflexarc.wiring.policy_trials import BackendName
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
    from reflexarc_sim_bridge.evaluation.protocol.setting import Setting

_AGENTS, _STEPS = 4096, 2000
_MOST_HZ = 10_000.0
_LOSS = 0.1
STATUS = {"keeps": 0, "loses": 1, "undecided": 3}
"""Exit status of a comparison."""


@dataclass(frozen=True)
class EvaluateCommand:
    """Measure policies on test worlds, beside an agent that never steers.

    Without --suite: on the reference field; the figure is contacts per 100 m, with a 95 % interval
    (bootstrap over agents). Bodies that turn have no such figure: theirs is the greatest distance
    before the first contact, in 60 s. With --suite: in all its worlds, at the robot's rate and body
    and at the field's; the figure is a score, 0 for an agent that never steers and 1 for what is
    possible, family by family. Writes results.json and the page index.html into
    runs/evaluation-SUITE. After Ctrl-C, or
    worse, --resume goes on. With --against: one policy is compared with an older one on the same
    validation worlds; exit status 0 if it loses no more than --loss in any family, 1 if it loses
    more in one, 3 if neither could be shown. Policies are greedy; each has its own eye.

    Examples:
      reflexarc evaluate runs/reflex-0/policy.onnx
      reflexarc evaluate runs/*/policy.onnx --agents 1024 --json
      reflexarc evaluate runs/*/policy.onnx --baseline braitenberg-2a --suite lite
      reflexarc evaluate --controller mine.py:Mine --world crossing --rate 20
      reflexarc evaluate new.onnx --against old.onnx --loss 0.1
    """

    policies: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Exported policies (ONNX)."""
    controller: tuple[str, ...] = ()
    """Policies in Python: module:Class or file.py:Class, with `contract` and `decide`."""
    baseline: tuple[str, ...] = ()
    """Earlier systems and plain rules, by name; also blind and random."""
    suite: str = ""
    """lite, full, or the file of a suite."""
    family: tuple[str, ...] = ()
    """Only these families of the suite."""
    setting: Literal["both", "robot", "field"] = "both"
    """In a suite: the rate and the body of the contract, 10 Hz and a point, or both."""
    world: str = ""
    """Without a suite: another world than the reference field's, by name or file."""
    rate: float = 0.0
    """Decisions a second of all of them; by default their contracts', on the field its own 10."""
    agents: int = _AGENTS
    """On the field: agents, each in a world of its own."""
    steps: int = _STEPS
    """On the field: counted steps of each agent; 100 more come first and do not count."""
    guard: bool = False
    """Drive behind the guard that `reflexarc run` has, and say how often it stepped in. The agent
    that never steers drives without one."""
    backend: BackendName = "numpy"
    """What computes the policies."""
    jobs: int = 0
    """Processes of a suite; by default as many as there are processors."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Folder of a suite's results; runs/evaluation-SUITE by default."""
    resume: bool = False
    """Go on with a suite that was interrupted: take what its folder has of the same cells, the same
    contenders and the same code."""
    page: bool = True
    """Draw a suite's results as one page that a browser opens, with its worst moments."""
    against: str = ""
    """An older policy, or a controller or baseline: does the given one lose by the change?"""
    loss: float = _LOSS
    """With --against: largest share of more contacts in a family that is borne."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Measure, and print tables."""
        from reflexarc.wiring.entrants import entrants_of

        self._check()
        entrants = entrants_of(
            self.policies,
            self.controller,
            self.baseline,
            guard=self.guard,
            rate_hz=self.rate or None,
            backend=self.backend,
        )
        if self.against:
            return self._run_comparison(entrants)
        return self._run_suite(entrants) if self.suite else self._run_field(entrants)

    def _check(self) -> None:
        from reflexarc_runtime.crew.crew import MOST_JOBS

        if self.agents < 1 or self.steps < 1:
            raise UsageError(f"--agents, --steps: expected ≥ 1, got {self.agents}, {self.steps}")
        if not (self.rate == 0.0 or 0.1 <= self.rate <= _MOST_HZ):
            raise UsageError(f"--rate: expected 0.1 to {_MOST_HZ:g}, got {self.rate}")
        if not 0 <= self.jobs <= MOST_JOBS:
            raise UsageError(f"--jobs: expected 1 to {MOST_JOBS}, got {self.jobs}")
        if self.against:
            _refuse("without --against", world=self.world, out=self.out, resume=self.resume)
            _refuse("without --against", agents=self.agents != _AGENTS, steps=self.steps != _STEPS)
            if not 0.0 < self.loss <= 10.0:
                raise UsageError(f"--loss: expected a share in (0, 10], got {self.loss}")
        elif self.suite:
            _refuse("without --suite", world=self.world)
            _refuse("without --suite", agents=self.agents != _AGENTS, steps=self.steps != _STEPS)
            if self.setting == "field" and self.rate:
                raise UsageError("--rate: expected --setting robot or both; the field's is 10 Hz")
        else:
            _refuse("with --against", loss=self.loss != _LOSS)
            _refuse("with --suite", family=self.family, jobs=self.jobs, out=self.out)
            _refuse("with --suite", resume=self.resume, setting=self.setting != "both")
            _refuse("with --suite", no_page=not self.page)

    def _run_comparison(self, entrants: "list[Entrant]") -> int:
        from reflexarc.terminal.suite_progress import show_suite_progress
        from reflexarc.terminal.verdict_table import WORDS, plain_verdicts, verdict_table
        from reflexarc.wiring.entrants import entrant_of
        from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
        from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
        from reflexarc_sim_bridge.evaluation.running.compare import Terms, compare
        from reflexarc_sim_bridge.evaluation.running.evaluate import processors
        from reflexarc_sim_bridge.evaluation.scoring.regression import overall

        if len(entrants) != 1:
            raise UsageError(f"--against: expected one policy to judge, got {len(entrants)}")
        rate_hz = self.rate or None
        old = entrant_of(self.against, guard=self.guard, rate_hz=rate_hz, backend=self.backend)
        suite = suite_named(self.suite or "lite")
        suite = suite.only(self.family) if self.family else suite
        setting = Setting.FIELD if self.setting == "both" else Setting(self.setting)
        with terminated_as_interrupted(), show_suite_progress("families") as progress:
            verdicts = compare(
                entrants[0],
                old,
                suite,
                setting,
                Terms(self.loss),
                self.jobs or processors(),
                progress,
            )
        claim = overall(verdicts)
        if self.json:
            print_json(plain_verdicts(verdicts, claim))
        else:
            title = f"{entrants[0].name} against {old.name}, {setting}, margin {self.loss:.0%}"
            console.print(verdict_table(verdicts, title))
            console.print(WORDS[claim])
        return STATUS[claim]

    def _run_field(self, entrants: "list[Entrant]") -> int:
        from reflexarc.commands.learn.field_scores import FieldPlan, distances, field_scores
        from reflexarc.terminal.field_tables import (
            contacts_table,
            distances_table,
            plain_distance,
            plain_score,
        )

        contenders = [each.contender() for each in entrants]
        plan = FieldPlan(self.agents, self.steps, self.world, self.rate or None)
        sideways = [each for each in contenders if not each.turns]
        turning = [each for each in contenders if each.turns]
        scores = field_scores(sideways, plan, progress_bar) if sideways else {}
        reached = distances(turning, plan)
        if self.json:
            blind = scores["blind"].contacts_per_100m if scores else 0.0
            contacts = {name: plain_score(score, blind) for name, score in scores.items()}
            print_json({**contacts, **{n: plain_distance(d) for n, d in reached.items()}})
            return 0
        where = f"{self.world or 'Reference field'}, test worlds"
        if scores:
            console.print(contacts_table(scores, where, guarded=self.guard))
        if reached:
            console.print(distances_table(reached, where))
        return 0

    def _run_suite(self, entrants: "list[Entrant]") -> int:
        from reflexarc.terminal.score_tables import score_tables
        from reflexarc.terminal.suite_progress import show_suite_progress
        from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
        from reflexarc_sim_bridge.evaluation.running.evaluate import (
            document_of,
            processors,
            write_results,
        )
        from reflexarc_sim_bridge.evaluation.running.run_suite import RunOptions, run_suite
        from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards

        suite = suite_named(self.suite)
        suite = suite.only(self.family) if self.family else suite
        out = self.out or Path("runs") / f"evaluation-{suite.name}"
        try:
            with terminated_as_interrupted(), show_suite_progress(suite.title) as progress:
                options = RunOptions(self.jobs or processors(), out, self.resume, progress)
                run = run_suite(suite, entrants, self._settings, options)
        except KeyboardInterrupt:
            aside.print(f"interrupted; what is done is kept in {out}: --resume goes on")
            raise
        cards = score_cards(run.results)
        write_results(out, run, cards)
        drawn = self.page and _draw_page(out, self.suite, entrants)
        if self.json:
            print_json(document_of(run.results, cards))
            return 0
        for table in score_tables(run.results, cards):
            console.print(table)
        console.print(f"results: {out / ('index.html' if drawn else 'results.json')}")
        return 0

    @property
    def _settings(self) -> "tuple[Setting, ...]":
        from reflexarc_sim_bridge.evaluation.protocol.setting import Setting

        return tuple(Setting) if self.setting == "both" else (Setting(self.setting),)


def _draw_page(out: Path, suite: str, entrants: "list[Entrant]") -> bool:
    """Draw the page, if the extra for pictures is there, with moments of those given here."""
    try:
        from reflexarc_pictures.rendering import render_results
    except ModuleNotFoundError as missing:
        aside.print(f"no page: {missing.name} is missing: pip install 'reflexarc[pictures]'")
        return False
    code = [entrant.source for entrant in entrants if entrant.is_code]
    render_results(out / "results.json", out / "index.html", suite, progress_bar, code)
    return True


def _refuse(when: str, **flags: object) -> None:
    """Refuse flags that would change nothing."""
    for name, given in flags.items():
        if given:
            raise UsageError(f"--{name.replace('_', '-')}: expected only {when}")
