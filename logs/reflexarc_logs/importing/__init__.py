"""Imports lidar logs of other systems (CARMEN, CoreSLAM) as MCAP logs."""
