"""The pages of the studies: `make studies`, or this alone once they are run.

Takes the page and the picture of every study that is shipped from `runs/study-NAME`, where
`reflexarc study NAME` left them, into `studies/`, and writes `studies/README.md` with all of their
tables. A study that has not been run to its end there keeps the page that it has from an earlier
time. Exit status: 1 if there is such a study.
"""

import sys
from pathlib import Path

from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.study.shipped import study_named, study_names
from reflexarc_trainer.study.study import PAGE, PICTURE

RUNS = Path("runs")
PAGES = Path(__file__).parent / "studies"

INTRODUCTION = """\
# Studies

`make studies` runs them all, makes these pages, and takes about half an hour on two cores; one is
`reflexarc study NAME`. Worlds are those of test seeds, which nobody has learned in. Means are
interquartile means over seeds, with the 95 % interval of a bootstrap over seeds; dots are seeds.
What stands below a question is computed from the results.
Each study's own page has its file, its versions and its commit.
"""

ASIDE = "## Where it comes from"
"""What follows it on a study's page is left to that page."""


def main(runs: Path = RUNS) -> int:
    """Copy what there is, and write the page of all."""
    PAGES.mkdir(parents=True, exist_ok=True)
    sections, missing = [INTRODUCTION], []
    for name in study_names():
        try:
            sections.append(_section(name, runs / f"study-{name}"))
        except ReflexarcError as error:
            print(f"studies: {error}", file=sys.stderr)
            missing.append(name)
            sections += [_summary(name)] if (PAGES / f"{name}.md").exists() else []
    never = [name for name in missing if not (PAGES / f"{name}.md").exists()]
    if never:
        sections.append(f"Not run to their end yet: {', '.join(never)}.\n")
    (PAGES / "README.md").write_text("\n".join(sections), encoding="utf-8")
    return 1 if missing else 0


def _section(name: str, folder: Path) -> str:
    """A study in the page of all; its own page and picture are copied.

    Raises:
        UsageError: it has not been run to its end.
    """
    study, picture = study_named(name), f"{name}.png"
    units = len(study.cells) * len(study.seeds)
    page = (folder / PAGE).read_text(encoding="utf-8") if (folder / PAGE).exists() else ""
    if f"| runs | {units} of {units} |" not in page:
        raise UsageError(f"{folder}: not run to its end; go on with: reflexarc study {name}")
    page = page.replace(f"({PICTURE})", f"({picture})")
    (PAGES / picture).write_bytes((folder / PICTURE).read_bytes())
    (PAGES / f"{name}.md").write_text(page, encoding="utf-8")
    return _summary(name)


def _summary(name: str) -> str:
    """What the page of all says of a study that has a page."""
    page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    body = page.partition(ASIDE)[0].replace("\n## ", "\n### ").strip()
    return f"#{body}\n\n[The file of this study, and where it comes from]({name}.md)\n"


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
