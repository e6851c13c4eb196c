"""The leaderboard: a line for each contender, the best headline score first."""

from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.page_content import Entry, PageContent
from reflexarc_pictures.suite_page.plot import Scale, svg
from reflexarc_pictures.suite_page.tables import interval_words, note, row, section, table
from reflexarc_pictures.suite_page.told import CONTACTS, REVERSALS, SWITCHES, number
from reflexarc_runtime.contract.eye_in_words import eye_in_words
from reflexarc_sim_bridge.evaluation.protocol.results import Agent
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval
from reflexarc_sim_bridge.worlds.reference_contract import reference_retina

SETTINGS = {
    Setting.ROBOT: "robot: the rate and the body of its contract",
    Setting.FIELD: "field: a point, ten decisions a second",
}
_BAR_WIDTH, _BAR_HEIGHT = 150.0, 16.0


def leaderboard(content: PageContent) -> Markup:
    """The section."""
    head = ["", "contender", *(f"score, {setting}" for setting in content.settings)]
    head += ["worst family", "contacts / 100 m", "switches / s", "reversals / s"]
    head += ["robustness", "eye", "trained or tuned"]
    scale = _scale(content)
    lines = [_line(content, entry, scale) for entry in content.entries]
    explained = "; ".join(SETTINGS[setting] for setting in content.settings)
    return section(
        "Leaderboard",
        "leaderboard",
        table(map(_title, head), lines, class_="board", id="board"),
        note(
            "Score: 0 for an agent that never steers, 1 for what is possible there, with its 95 %"
            " interval; the mean over families. A score below 0 is worse than never steering. ",
            f"{explained}. Figures after the scores are of the first setting, over all cells."
            " Contacts: none of a body that turns, which has no way ahead. Smoothness is no part of"
            " any score. Click a heading to sort.",
        ),
        _intervals(content),
    )


def eye_words(agent: Agent) -> str:
    """Whether it has the eye that learners are compared at, or which one of its own."""
    if agent.eye.endswith(", ranges"):
        return "own: ranges"
    if agent.eye.startswith(f"{eye_in_words(reference_retina())} "):
        return "reference"
    fields = dict(part.split("=", 1) for part in agent.eye.split() if "=" in part)
    try:
        degrees = float(fields["fov_rad"]) * 57.29578
        return f"own: {fields['rays']} rays, {degrees:.0f}\u00b0, {fields['range_m']} m"
    except (KeyError, ValueError):
        return "own"


def _title(words: str) -> Markup:
    return element("th", words, scope="col")


def _line(content: PageContent, entry: Entry, scale: Scale) -> Markup:
    setting = content.settings[0]
    card, rows = entry.cards.get(setting), content.rows(entry, setting)
    contacts = None if entry.turns else CONTACTS.of(rows)
    scores = [_score(entry, each, scale) for each in content.settings]
    worst = "" if card is None else card.worst_family
    area = None if card is None else card.robustness_area
    first = entry.agents[0]
    tuned = first.tuned if len(entry.agents) == 1 else f"{len(entry.agents)} training seeds"
    return row(
        element("td", str(entry.place), class_="place", data_v=entry.place),
        element("th", entry.name, scope="row"),
        *scores,
        _worst(worst, card.families[worst].value if card else None),
        _number(contacts),
        _number(SWITCHES.of(rows)),
        _number(REVERSALS.of(rows)),
        _number(area),
        element("td", eye_words(first), class_="words"),
        element("td", tuned or "\u2013", class_="words"),
    )


def _score(entry: Entry, setting: Setting, scale: Scale) -> Markup:
    card = entry.cards.get(setting)
    if card is None:
        return element("td", number(None), class_="num")
    score = card.headline
    return element(
        "td",
        element("b", number(score.value, 3)),
        _bar(score, scale),
        element("i", interval_words(score, 3) or "no interval"),
        class_="score",
        data_v=f"{score.value:.6f}",
    )


def _bar(score: Interval, scale: Scale) -> Markup:
    """A bar from 0 to the score, and its interval as a line over it."""
    zero, value = scale.at(0.0), scale.at(score.value)
    shown = element(
        "rect",
        class_="bar" if score.value >= 0.0 else "bar below",
        x=min(zero, value),
        y=3,
        width=abs(value - zero),
        height=_BAR_HEIGHT - 6,
    )
    parts = [shown, element("line", class_="axis", x1=zero, x2=zero, y1=0, y2=_BAR_HEIGHT)]
    if score.low is not None and score.high is not None:
        ends = scale.at(score.low), scale.at(score.high)
        middle = _BAR_HEIGHT / 2
        parts.append(
            element("line", class_="whisker", x1=ends[0], x2=ends[1], y1=middle, y2=middle)
        )
    return svg(_BAR_WIDTH, _BAR_HEIGHT, f"score {number(score.value, 3)}", joined(parts))


def _scale(content: PageContent) -> Scale:
    scores = [card.headline for entry in content.entries for card in entry.cards.values()]
    least = min([0.0, *(score.value if score.low is None else score.low for score in scores)])
    return Scale(least, 1.0, 2.0, _BAR_WIDTH - 2.0)


def _worst(family: str, score: float | None) -> Markup:
    value = number(score)
    sort = "" if score is None else f"{score:.6f}"
    return element("td", element("b", value), " ", family, class_="words", data_v=sort)


def _number(value: float | None) -> Markup:
    sort = "" if value is None else f"{value:.6f}"
    return element("td", number(value), class_="num", data_v=sort)


def _intervals(content: PageContent) -> Markup:
    notes = dict.fromkeys(card.note for card in content.cards)
    return note("Intervals: ", "; ".join(notes), ".")
