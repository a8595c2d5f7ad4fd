"""Builders of reports of robots, poses and results, as sections of tables, facts and sentences."""
