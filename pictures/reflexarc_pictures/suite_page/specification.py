"""Who was measured, how, and how to measure it again: what a reader needs to repeat it."""

import re
import shlex
from collections.abc import Iterator, Sequence

from reflexarc_pictures.suite_page.leaderboard import SETTINGS
from reflexarc_pictures.suite_page.markup import Markup, element
from reflexarc_pictures.suite_page.page_content import PageContent
from reflexarc_pictures.suite_page.tables import paragraph, row, section, table
from reflexarc_sim_bridge.evaluation.driving.drive import DISCARDED_M
from reflexarc_sim_bridge.evaluation.protocol.results import Agent, Results
from reflexarc_sim_bridge.worlds.seeds import test_seeds

_CODE = re.compile(r":\w+$")
_SUITE_VERSION = re.compile(r"-\d+$")


def protocol_section(content: PageContent) -> Markup:
    """The procedure: suite, worlds, amounts, settings, seeds."""
    return section(
        "Protocol",
        "protocol",
        table(["", ""], [row(element("th", *a), b) for *a, b in _facts(content)], class_="plain"),
        _worlds(content),
    )


def agents_section(content: PageContent) -> Markup:
    """The specification of each contender."""
    head = ["contender", "made from", "eye", "motion", "body", "rate", "trained or tuned"]
    return section(
        "Contenders",
        "contenders",
        table(head, [_agent(agent) for agent in content.results.agents], class_="plain agents"),
    )


def reproduction_section(content: PageContent) -> Markup:
    """The command that measures all this again."""
    return section(
        "Measure it again",
        "again",
        element("pre", content.command or command_of(content.results)),
        paragraph(
            f"with reflexarc {content.results.version} and the same files, whose hashes stand"
            " above: the same files, suite and version give the same numbers to the last digit, on"
            " any number of processes. All but the moments is drawn from results.json alone."
        ),
    )


def command_of(results: Results) -> str:
    """The command line that measured results, as far as they say."""
    words = ["reflexarc", "evaluate"]
    files = [agent.source for agent in results.agents if not _CODE.search(agent.source)]
    words += files
    for agent in results.agents:
        if _CODE.search(agent.source):
            words += ["--controller", agent.source]
    words += ["--suite", _SUITE_VERSION.sub("", results.suite)]
    settings = {row.setting for row in results.rows}
    if len(settings) == 1:
        words += ["--setting", str(settings.pop())]
    if results.agents and all(agent.motion.endswith(", guarded") for agent in results.agents):
        words.append("--guard")
    return shlex.join(words)


def _facts(content: PageContent) -> Iterator[tuple[str, str]]:
    results, suite = content.results, content.suite
    worlds, lanes = _worlds_and_lanes(results)
    yield "suite", results.suite
    yield "software", f"reflexarc {results.version}"
    yield "families, cells", f"{len(content.families)}, {len(results.cells)}"
    yield "in each cell", f"{worlds} worlds, {lanes} agents in each that do not see each other"
    if suite is not None:
        yield (
            "counted",
            f"{suite.free_paths:g} mean free paths of an agent that never steers, after"
            f" {DISCARDED_M:g} m that do not count; a body that turns for {suite.turner_s:g} s",
        )
    yield "settings", "; ".join(SETTINGS[setting] for setting in content.settings)
    yield (
        "contact",
        "an onset of overlap, found along the swept step; the agent then stands at the same x, at a"
        " y drawn evenly among the free places",
    )
    yield "decisions", "greedy, ties stay, one in each step"
    yield (
        "score",
        "of a cell: (C_blind \u2212 C) / (C_blind \u2212 C_oracle), at most 1 and at least \u22121;"
        " C: contacts per 100 m, of a body that turns the distance that it does not get; where no"
        " oracle is known, 0 contacts. Of a family: mean over its cells that count. Headline: mean"
        " over families",
    )
    limits = sorted({row.contender for row in results.limits})
    yield "limits", "; ".join(limits) or "none"
    yield (
        "seeds",
        "test worlds: the first 8 bytes of SHA-256 of \u201creflexarc test worlds 1:\u201d and"
        f" 0, 1, \u2026, with the top bit set: {', '.join(map(str, test_seeds(min(worlds, 8))))}"
        + (", \u2026" if worlds > 8 else ""),
    )


def _worlds_and_lanes(results: Results) -> tuple[int, int]:
    """Of the first row: all rows have as many."""
    agents = results.rows[0].sums["agents"] if results.rows else [0.0]
    return len(agents), round(agents[0])


def _worlds(content: PageContent) -> Markup:
    lines = [
        row(
            cell.family,
            cell.tier,
            cell.world,
            "as the world says" if cell.clutter is None else f"{cell.clutter:g}",
            "yes" if cell.counts else "no",
        )
        for cell in content.results.cells
    ]
    head = ["family", "tier", "world", "clutter", "counts"]
    shown = table(head, lines, class_="plain")
    return element("details", element("summary", f"{len(lines)} cells"), shown)


def _agent(agent: Agent) -> Markup:
    return row(
        element("th", agent.name, scope="row"),
        element("td", _source(agent)),
        element("td", agent.eye, class_="fine"),
        agent.motion,
        agent.body,
        f"{agent.rate_hz:g} Hz",
        agent.tuned or "\u2013",
    )


def _source(agent: Agent) -> Sequence[Markup]:
    shown = [element("span", agent.source)]
    if agent.hash:
        shown.append(element("code", f" SHA-256 {agent.hash}", class_="fine"))
    return shown
