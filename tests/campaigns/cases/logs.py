"""Logs that were cut, damaged, compressed or written again by other tools."""

import json

from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from cases.case import Case, Outcome, Said, Stage, Trial


def _info(file: str, messages: int) -> Trial:
    """`info` counts them."""

    def trial(stage: Stage) -> Outcome:
        said = stage.reflexarc("info", stage.inputs / file, "--json")
        got = json.loads(said.out)["messages"] if said.status == 0 else said.complaint.strip()
        return Outcome(got == messages, f"{got} messages")

    return trial


def _identical(file: str) -> Trial:
    """`replay` is identical at both levels."""

    def trial(stage: Stage) -> Outcome:
        said = stage.reflexarc("replay", stage.inputs / file)
        levels = [line for line in said.out.splitlines() if "level" in line and "101 ticks" in line]
        return Outcome(said.status == 0 and len(levels) == 2, _last(said))

    return trial


def _foreign(file: str) -> Trial:
    """No command calls it damaged; `replay` says that it is another system's."""

    def trial(stage: Stage) -> Outcome:
        path = stage.inputs / file
        saids = [stage.reflexarc("info", path), stage.reflexarc("replay", path)]
        saids += [stage.reflexarc("play", path), _recover(stage, file)]
        damaged = any("damaged" in said.everything for said in saids)
        is_named = "another system" in saids[1].complaint and "another system" in saids[0].out
        return Outcome(is_named and not damaged, _last(saids[1]))

    return trial


def _saves(file: str, messages: int, status: int, *words: str) -> Trial:
    """`recover` saves so many messages, ends so, and says these words."""

    def trial(stage: Stage) -> Outcome:
        said = _recover(stage, file)
        lines = [" ".join(line.split()) for line in said.out.splitlines()]
        wanted = [f"messages {messages}", *words]
        missing = [words for words in wanted if not any(words in line for line in lines)]
        seen = "; ".join(lines[:6])
        return Outcome(said.status == status and not missing, f"status {said.status}: {seen}")

    return trial


def _keeps_a_channel(stage: Stage) -> Outcome:
    _recover(stage, "with-ros-topic.mcap")
    channels, counts = {}, 0
    with (stage.scratch / "saved.mcap").open("rb") as file:
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                channels[record.topic] = record
            counts += isinstance(record, Message)
    camera = channels["/camera/image_raw"]
    kept = camera.message_encoding == "cdr" and "offered_qos_profiles" in camera.metadata
    return Outcome(kept and counts == 558, f"{counts} messages, {camera.message_encoding}")


def _keeps_an_attachment(stage: Stage) -> Outcome:
    _recover(stage, "with-attachment.mcap")
    saved = (stage.scratch / "saved.mcap").read_bytes()
    return Outcome(b"notes.txt" in saved, "it is there" if b"notes.txt" in saved else "it is gone")


def _one_line_at_most(stage: Stage) -> Outcome:
    said = stage.reflexarc("replay", stage.inputs / "all-times.mcap")
    lines = said.complaint.strip().splitlines()
    holds = not said.has_traceback and (said.status != 2 or len(lines) == 1)
    return Outcome(holds, f"status {said.status}: {_last(said)}")


def _recover(stage: Stage, file: str) -> Said:
    words = "recover", stage.inputs / file, "-o", stage.scratch / "saved.mcap"
    return stage.reflexarc(*words, COLUMNS="200")


def _last(said: Said) -> str:
    return (said.complaint or said.out).strip().splitlines()[-1][-150:]


CASES: tuple[Case, ...] = (
    Case("mcap-no-summary", "chunks, no index: info", "507 messages", _info("chunked.mcap", 507)),
    Case("mcap-no-summary", "chunks, no index: replay", "identical", _identical("chunked.mcap")),
    *(
        Case(
            "mcap-no-summary",
            f"{name}, of the conformance suite",
            "a log of another system",
            _foreign(f"conformance-{name}.mcap"),
        )
        for name in ("NoData", "TenMessages", "OneMetadata-pad")
    ),
    Case("mcap-recompressed", "lz4: info", "507 messages", _info("lz4.mcap", 507)),
    Case("mcap-recompressed", "lz4: replay", "identical", _identical("lz4.mcap")),
    Case("mcap-recompressed", "lz4: recover", "507 messages", _saves("lz4.mcap", 507, 0)),
    Case("recover-keeps", "a topic of ROS", "558 messages, cdr", _keeps_a_channel),
    Case("recover-keeps", "an attachment", "kept", _keeps_an_attachment),
    Case(
        "recover-says",
        "a bit of the ninth chunk",
        "469 messages, 38 missing in the middle, none at the end",
        _saves("middle-chunk-flipped.mcap", 469, 1, "lost, middle 38", "lost, end nothing"),
    ),
    Case(
        "recover-says",
        "a second log behind the end",
        "66 KiB behind the end were not read",
        _saves("two-logs-concatenated.mcap", 507, 1, "behind the end another log, not read, 66"),
    ),
    Case(
        "recover-says",
        "no message index",
        "507 messages, nothing lost",
        _saves("message-indexes-missing.mcap", 507, 0, "lost nothing"),
    ),
    Case("times-beyond-int64", "all times near 2^64", "one line at most", _one_line_at_most),
)
