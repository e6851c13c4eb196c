"""What people of the field meet, kind by kind."""

from cases import bags, bodies, cameras, lidar_logs, logs, machines, nets, policies, replays, scans

FAMILIES = (logs, replays, bags, lidar_logs, scans, cameras, bodies, policies, nets, machines)
