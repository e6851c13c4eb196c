"""Makes `logs/foxglove-layout.json` with Foxglove's own SDK, which knows what a layout may say.

pip install foxglove-sdk
python docs/foxglove_layout.py
"""

import json
from pathlib import Path

import foxglove.layouts as fl

ROBOT = "robot0"
OUT = Path(__file__).parents[1] / "logs" / "foxglove-layout.json"
COLOURS = ("#009e73", "#0072b2", "#d55e00")
"""Of the paper's three actions, as in our own pictures (Okabe and Ito)."""
VERDICTS = {
    1: ("OK", "#009e73"),
    2: ("NO_INPUT", "#b4bcc4"),
    3: ("STALE_INPUT", "#e69f00"),
    4: ("INVALID_INPUT", "#e69f00"),
    5: ("RECOVERING", "#f0e442"),
    6: ("POLICY_FAULT", "#d55e00"),
    7: ("STOPPED", "#b4bcc4"),
    8: ("TWO_SOURCES", "#d55e00"),
    9: ("OVERRUN", "#d55e00"),
    10: ("GUARDED", "#56b4e9"),
    11: ("STUCK", "#cc79a7"),
}


def topic(name: str) -> str:
    """A topic of the robot, or a path into its messages."""
    return f"/{ROBOT}/{name}"


def world() -> fl.Content:
    """Obstacles, beams and poses in space."""
    shown = fl.ThreeDeeConfig(
        follow_tf=ROBOT,
        follow_mode="follow-position",
        topics={
            topic("scene"): fl.BaseRendererSceneUpdateTopicSettings(visible=True),
            topic("scan"): fl.BaseRendererLaserScanTopicSettings(visible=True, point_size=4),
            topic("pose"): fl.BaseRendererPoseTopicSettings(visible=True, type="arrow"),
            topic("odometry"): fl.BaseRendererPoseTopicSettings(visible=True, type="axis"),
        },
    )
    return fl.ThreeDeePanel(config=shown, title="World")


def retina() -> fl.Content:
    """What the policy sees."""
    mode = fl.ImageModeConfig(image_topic=topic("retina"), image_schema_name="foxglove.RawImage")
    return fl.ImagePanel(config=fl.ImageConfig(image_mode=mode), title="Retina")


def curves(title: str, *paths: tuple[str, str, str]) -> fl.Content:
    """Values over time: path, label and colour of each."""
    series = [
        fl.PlotSeries(value=topic(path), label=label, color=colour, timestamp_method="receiveTime")
        for path, label, colour in paths
    ]
    config = fl.PlotConfig(paths=series, x_axis_val="timestamp", show_legend=True, is_synced=True)
    return fl.PlotPanel(config=config, title=title)


def q_values() -> fl.Content:
    """What each action is worth."""
    paths = [
        (f"tick.decision.q_values[{number}]", f"action {number}", colour)
        for number, colour in enumerate(COLOURS)
    ]
    return curves("Q-values", *paths)


def command() -> fl.Content:
    """What the body is told."""
    names = ("linear_mps", "lateral_mps", "angular_radps")
    paths = [(f"command.{n}", n, c) for n, c in zip(names, COLOURS, strict=True)]
    return curves("Command", *paths)


def verdicts() -> fl.Content:
    """What each tick decided."""
    states = [
        fl.StateTransitionsDiscreteCustomState(value=str(number), label=name, color=colour)
        for number, (name, colour) in VERDICTS.items()
    ]
    series = [
        fl.StateTransitionsSeries(
            value=topic("tick.decision.verdict"),
            label="verdict",
            timestamp_method="receiveTime",
            custom_states=fl.StateTransitionsDiscreteCustomStates(states=states),
        ),
        fl.StateTransitionsSeries(
            value=topic("tick.decision.action"), label="action", timestamp_method="receiveTime"
        ),
    ]
    config = fl.StateTransitionsConfig(paths=series, is_synced=True)
    return fl.StateTransitionsPanel(config=config, title="Verdict and action")


def words() -> fl.Content:
    """Why, and what was said."""
    log = fl.LogPanel(config=fl.LogConfig(topic_to_render=topic("log")), title="Log")
    reason = fl.RawMessagesConfig(topic_path=topic("tick.decision.reason"))
    tick = fl.RawMessagesPanel(config=reason, title="Reason")
    return split("row", (1, tick), (2, log))


def split(direction: str, *items: tuple[float, fl.Content]) -> fl.Content:
    """Panels beside or below one another, each with its share."""
    parts = [fl.SplitItem(proportion=share, content=content) for share, content in items]
    return fl.SplitContainer(direction=direction, items=parts)


def layout() -> str:
    """The whole layout as JSON, one line for each value."""
    beside = split(
        "column", (1, retina()), (2, q_values()), (2, command()), (1.5, verdicts()), (1, words())
    )
    whole = fl.Layout(content=split("row", (1, world()), (1, beside)))
    return json.dumps(json.loads(whole.to_json()), indent=2) + "\n"


if __name__ == "__main__":
    OUT.write_text(layout(), encoding="utf-8")
