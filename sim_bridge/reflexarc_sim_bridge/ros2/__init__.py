"""A robot that speaks ROS 2 over Zenoh, as a body on our bus. No ROS is needed."""
