"""Prints a report as one HTML file that needs nothing else and prints on A4."""

from __future__ import annotations

from importlib import resources

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from sessions.reports.language import _, marked, spoken
from sessions.reports.paper import Block, Paper
from sessions.reports.report import Report
from sessions.reports.session_paper import session_paper

TEMPLATES = resources.files("web_assets") / "reports"
_NOT_CERTIFIED = marked("This software is not a certified medical device.")
_SUPPORTS = marked(
    "Its numbers support a clinician's judgement and do not replace it. Measured with rehab-app %(version)s."
)


def render_html(report: Report) -> str:
    """One self-contained page; the same report gives the same bytes."""
    return html_of(session_paper(report))


def html_of(paper: Paper) -> str:
    """Any paper as a self-contained page."""
    environment = Environment(
        loader=FunctionLoader(_template),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["kind"] = kind_of
    environment.filters["drawn"] = (
        Markup  # only pictures, which are drawn here: every word in them is escaped
    )
    return (
        environment.get_template("paper.html.j2").render(
            paper=paper, language=spoken(), footer=footer(paper), floor=_("floor")
        )
        + "\n"
    )


def footer(paper: Paper) -> tuple[str, str]:
    """What stands at the end of every page: the part in bold, and the rest."""
    return _(_NOT_CERTIFIED), _(_SUPPORTS, version=paper.software_version)


def kind_of(block: Block) -> str:
    """The word by which the templates know a block."""
    return type(block).__name__.lower()


def _template(name: str) -> str:
    return (TEMPLATES / name).read_text(encoding="utf-8")
