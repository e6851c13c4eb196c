"""From the `results.json` of a suite to its page or its picture.

Such a file comes from anybody, and names who was measured. Nothing that it names is imported or
run: moments are drawn of agents whose source is a file, which is read as a policy, and of code that
whoever draws names himself.
"""

import json
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from reflexarc_pictures.suite_page.moment import Moment
from reflexarc_pictures.suite_page.page import write_page
from reflexarc_pictures.suite_page.page_content import PageContent
from reflexarc_pictures.suite_page.published_figure import draw_scores
from reflexarc_pictures.suite_page.worst_moments import Progress, worst_moments
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, RANDOM
from reflexarc_sim_bridge.evaluation.protocol.entrant import CODE, Entrant
from reflexarc_sim_bridge.evaluation.protocol.results import Agent, Results
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, suite_named, suite_shipped
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards

PAGE = ".html"
_GUARDED = ", guarded"


def read_results(path: Path) -> Results:
    """The results in a file.

    Raises:
        UsageError: it cannot be read, or is no results of a suite of this version.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return Results.from_json(document)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        said = f"{type(error).__name__}: {error}"
        raise UsageError(f"{path}: expected results of a suite of this version: {said}") from None


def content_of(
    results: Results,
    suite_name: str = "",
    progress: Progress | None = None,
    code: Collection[str] = (),
) -> PageContent:
    """What a page of results shows.

    Args:
        results: of a suite.
        suite_name: name or file of the suite; empty: the shipped one of its name and version.
        progress: follows the drives of the worst moments; None: no moments are looked for.
        code: sources of code, module:Class, that may be run to draw them.

    Raises:
        UsageError: nobody was measured, or no cell tells anything.
    """
    name, suite = _suite_of(results, suite_name)
    content = PageContent(results, score_cards(results), suite)
    if progress is None or suite is None or not content.entries:
        return content
    return PageContent(
        results, content.cards, suite, _moments(content, suite, name, progress, code)
    )


def draw_results(
    results: Results,
    out: Path,
    suite_name: str = "",
    progress: Progress | None = None,
    code: Collection[str] = (),
) -> None:
    """Write the page, or the picture, of results.

    Args:
        results: of a suite.
        out: the page (HTML) or the picture (PNG).
        suite_name: see `content_of`.
        progress: see `content_of`.
        code: see `content_of`.

    Raises:
        UsageError: nobody was measured, or no cell tells anything.
        OSError: the file cannot be written.
    """
    if out.suffix.lower() == PAGE:
        write_page(content_of(results, suite_name, progress, code), out)
    else:
        draw_scores(content_of(results, suite_name), out)


def _suite_of(results: Results, name: str) -> tuple[str, Suite | None]:
    """The suite of that name, or that of the results' own; None if it is another version."""
    own = results.suite.rpartition("-")[0]
    try:
        suite = suite_named(name) if name else suite_shipped(own)
    except (ReflexarcError, OSError):
        return name or own, None
    return name or own, suite if suite.title == results.suite else None


def _moments(
    content: PageContent, suite: Suite, name: str, progress: Progress, code: Collection[str]
) -> Sequence[Moment]:
    """Those of the first contender that can still be made; of none if it is no longer the same."""
    for entry in content.entries:
        card = entry.cards.get(content.settings[0])
        if card is None or len(entry.agents) > 1 or not _may_be_made(entry.agents[0], code):
            continue
        try:
            entrant = _same(entry.agents[0])
            if entrant is not None:
                return worst_moments(entrant, card, suite, name, progress)
        except (ReflexarcError, OSError, ImportError):
            continue
    return ()


def _may_be_made(agent: Agent, code: Collection[str]) -> bool:
    """Whether it is a file, or code that whoever draws has named: nothing else is even looked for.

    What could be either by its text counts as code.
    """
    source = agent.source
    return source in (BLIND, RANDOM, *code) or (CODE not in source and Path(source).is_file())


def _same(agent: Agent) -> Entrant | None:
    """Who it was, at its rate; None if it is no longer the same."""
    entrant = Entrant(agent.name, agent.source, agent.motion.endswith(_GUARDED))
    if entrant.content_hash() != agent.hash:
        return None
    own_hz = entrant.contender().contract.rate_hz
    return entrant if own_hz == agent.rate_hz else replace(entrant, rate_hz=agent.rate_hz)
