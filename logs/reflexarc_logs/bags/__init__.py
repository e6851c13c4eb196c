"""Bags of ROS 2: read as logs of ours, and written out of them."""
