"""A body that speaks ROS 2 over Zenoh: scans in, twists out."""
