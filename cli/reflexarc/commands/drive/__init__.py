"""Commands that drive: sim, run, ros2, camera."""
