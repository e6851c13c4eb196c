"""The scanner of a ROS 2 robot, as a process: `python -m campaigns.ends.scanner PORT KEY`."""

import json
import sys
import threading

import zenoh

from support.ros2_robot import Robot


def main(port: int, key: str) -> None:
    """Scan until the end."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("scouting/multicast/enabled", json.dumps(False))
    config.insert_json5("connect/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    scanning = threading.Event()
    scanning.set()
    with zenoh.open(config) as session:
        print("scanner: ready", file=sys.stderr, flush=True)
        Robot(session, key, "", stamped=False, scanning=scanning).scan()


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
