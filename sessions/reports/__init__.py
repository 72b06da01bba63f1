"""Reports: what was measured, for a patient, a clinician and a program."""

from sessions.reports.exchange import render_json, report_object
from sessions.reports.formats import FORMATS, Format
from sessions.reports.note import render_note
from sessions.reports.page import html_of, render_html
from sessions.reports.pdf import pdf_of, render_pdf
from sessions.reports.report import Report, build_report, installed_version

__all__ = [
    "FORMATS",
    "Format",
    "Report",
    "build_report",
    "html_of",
    "installed_version",
    "pdf_of",
    "render_html",
    "render_json",
    "render_note",
    "render_pdf",
    "report_object",
]
