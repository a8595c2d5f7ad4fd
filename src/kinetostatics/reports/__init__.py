"""Builders of reports: what is told of robots, poses and results, as sections of tables, facts and sentences."""
