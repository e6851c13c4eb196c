"""The page of a judgement: the table of all logs, then each log by itself, the worst first.

One file, without scripts or anything else from elsewhere, which a rule in its head holds the
browser to. The same judgement gives the same bytes.
"""

from pathlib import Path

from reflexarc_logs.judging.amounts import share
from reflexarc_logs.judging.judgement import LogJudgement
from reflexarc_logs.judging.judgement_report import Judgement
from reflexarc_pictures.judgement_page.judged_logs import judged_logs
from reflexarc_pictures.judgement_page.look import look
from reflexarc_pictures.judgement_page.verdict_board import verdict_board
from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.plot import shortened
from reflexarc_pictures.suite_page.style import SORTING
from reflexarc_pictures.suite_page.tables import note
from reflexarc_runtime.files import write_atomically

_NOTHING_ELSE = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
)
_TITLE = 60


def write_judgement_page(judgement: Judgement, path: Path) -> int:
    """Write the page; an older file is replaced.

    Returns:
        Its size in bytes.

    Raises:
        OSError: the file cannot be written.
    """
    data = judgement_page(judgement).encode()
    write_atomically(path, data)
    return len(data)


def judgement_page(judgement: Judgement) -> str:
    """The page as text."""
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=_NOTHING_ELSE),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", f"reflexarc replay: {shortened(judgement.candidate, _TITLE)}"),
        element("style", Markup(look())),
    )
    body = element(
        "body",
        _opening(judgement),
        verdict_board(judgement.logs),
        judged_logs(judgement.logs),
        element("script", Markup(SORTING)),
    )
    return f"<!doctype html>\n{element('html', head, body, lang='en')}\n"


def _opening(judgement: Judgement) -> Markup:
    count = len(judgement.logs)
    judged_by = "; ".join(judgement.limits) or "no limits"
    return element(
        "header",
        element("h1", judgement.candidate),
        element(
            "p",
            element("b", judgement.verdict, class_=f"verdict v{judgement.exit_status}"),
            f" on {count} log{'' if count == 1 else 's'}: {_in_words(judgement)}",
            class_="lead",
        ),
        note(
            f"Judged by: {judged_by}. Policy {judgement.policy_hash[:12] or 'unnamed'}. Replay is"
            " open loop: the candidate was asked about what another policy saw, and what it"
            " answered moved nothing. A flip is a tick at which it prefers another action; its"
            " margin is the lead that the recorded action had, by the recorded Q-values. A reversal"
            " is a flip to the opposite action."
        ),
    )


def _in_words(judgement: Judgement) -> Markup:
    flips, ticks = judgement.flips, judgement.ticks
    words = (
        f"{flips:,} flips at {ticks:,} ticks ({share(flips, ticks)}), "
        f"{judgement.reversals:,} of them reversals."
    )
    return joined(words, _not_judged(judgement.logs))


def _not_judged(logs: tuple[LogJudgement, ...]) -> str:
    count = sum(bool(one.problem) for one in logs)
    return f" {count} could not be judged." if count else ""
