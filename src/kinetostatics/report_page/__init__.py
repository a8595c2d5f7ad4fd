"""Report page: one printable HTML file about a robot at a pose and over its workspace."""

from kinetostatics.report_page.write import save_report

__all__ = ["save_report"]
