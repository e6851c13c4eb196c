"""Environments with another framework, from the package index; its versions."""

import json
import subprocess
import sys
from pathlib import Path

RCLPY = (
    "ros-rclpy==9.1.2",
    "ros-rmw-fastrtps-cpp==9.3.3",
    "ros-rmw-implementation==3.0.4",
    "ros-std-msgs==5.5.1",
)
"""ROS 2 Kilted as wheels (github.com/ycheng517/ros-python-wheels); Fast DDS comes with them."""
DORA = ("dora-rs==1.1.0", "dora-rs-cli==1.1.0")
"""The node's library and the command with the daemon in it."""
SHOWN = ("ros-rclpy", "ros-rmw-fastrtps-cpp", "ros-fastdds", "dora-rs", "eclipse-zenoh", "numpy")


def prepared(folder: Path, packages: tuple[str, ...]) -> Path:
    """Make the environment if it is not there; its interpreter."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        words = [str(python), "-m", "pip", "install", "--quiet", "numpy", *packages]
        subprocess.run(words, check=True)
    return python


def versions(python: Path) -> str:
    """Versions of what is compared, in a line."""
    words = [str(python), "-m", "pip", "list", "--format", "json", "--disable-pip-version-check"]
    listed = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)
    found = {each["name"].lower(): each["version"] for each in listed}
    return ", ".join(f"{name} {found[name]}" for name in SHOWN if name in found)
