"""Bags of ROS 2, and names that look like markup."""

import json

from cases.case import Case, Outcome, Stage, Trial


def _listed(file: str, topics: dict[str, tuple[str, int]]) -> Trial:
    """`info` lists topics, types and counts, and says that the log is none of ours."""

    def trial(stage: Stage) -> Outcome:
        said = stage.reflexarc("info", stage.inputs / file, "--json")
        if said.status != 0:
            return Outcome(False, said.complaint.strip()[-150:])
        told = json.loads(said.out)
        got = {topic["topic"]: (topic["schema"], topic["messages"]) for topic in told["topics"]}
        words = stage.reflexarc("info", stage.inputs / file).out
        is_foreign = told["ours"] is False and "not a log of reflexarc" in words
        return Outcome(got == topics and is_foreign and told["duration_s"] > 0, str(got))

    return trial


def _imported(stage: Stage) -> Outcome:
    """There is a way to make a log of ours of it."""
    out = stage.scratch / "scans.mcap"
    said = stage.reflexarc("import", "ros2bag", stage.inputs / "rosbag2-laserscan.mcap", "-o", out)
    return Outcome(said.status == 0 and out.exists(), said.complaint.strip()[-150:])


TALKER = {"/rosout": ("rcl_interfaces/msg/Log", 10), "/topic": ("std_msgs/msg/String", 10)}
SCANS = {"/scan": ("sensor_msgs/msg/LaserScan", 20)}
CASES: tuple[Case, ...] = (
    Case("foreign-mcap", "a bag of ROS 2", "its topics", _listed("rosbag2-talker.mcap", TALKER)),
    Case("foreign-mcap", "a bag of scans", "its topics", _listed("rosbag2-laserscan.mcap", SCANS)),
    Case("foreign-mcap", "a bag of scans: import", "a log with its 20 scans", _imported),
)
