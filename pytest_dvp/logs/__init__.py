"""Logs from anywhere: CSV, .mat, MDF4, MCAP of others, ROS bags -> Log, with what was converted said in its meta."""
