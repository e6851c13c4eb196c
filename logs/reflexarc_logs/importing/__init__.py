"""Other people's lidar logs (CARMEN, CoreSLAM) as logs of ours."""
