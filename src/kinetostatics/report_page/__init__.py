"""A report for a colleague: one HTML page about a robot at a pose and over its workspace, to be read and printed."""

from kinetostatics.report_page.write import save_report

__all__ = ["save_report"]
