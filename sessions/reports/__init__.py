"""Reports: what was measured, for a patient, a clinician and a program."""

from sessions.reports.exchange import render_json, report_object
from sessions.reports.page import render_html
from sessions.reports.report import Report, build_report

__all__ = ["Report", "build_report", "render_html", "render_json", "report_object"]
