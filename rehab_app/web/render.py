"""Renders the shell's pages."""

from __future__ import annotations

from datetime import UTC, date, datetime
from importlib import resources
from typing import TYPE_CHECKING, Any

from babel.dates import format_date, format_datetime
from jinja2 import Environment, FunctionLoader, StrictUndefined
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from rehab_app.access import Account, Role
from rehab_app.web import language
from rehab_app.web.language import LANGUAGES, _, spoken
from rehab_app.web.signing import Ticket
from rehab_app.web.words import EXERCISES, JOINT_WORDS, MODES
from rehab_app.web.words_access import ROLE_WORDS

if TYPE_CHECKING:
    from rehab_app.web.site import Site

_FOLDER = resources.files("web_assets") / "templates"


def page_templates() -> Environment:
    """The templates; every value is escaped, a missing one is an error."""
    environment = Environment(
        loader=FunctionLoader(lambda name: (_FOLDER / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        extensions=["jinja2.ext.i18n"],
    )
    translating: Any = environment  # the extension adds its methods without types
    translating.install_gettext_callables(_, language.ngettext, newstyle=True)
    # The extension's own functions call every text safe, also one that a person typed: ours leave it escaped.
    known: Any = environment.globals
    known.update({"_": _text, "gettext": _text, "ngettext": _counted})
    environment.filters["day"] = day
    environment.filters["moment"] = moment
    environment.filters["instant"] = instant
    environment.filters["written"] = language.written
    environment.filters["exercise"] = exercise
    environment.filters["mode"] = mode
    environment.filters["role"] = role
    environment.filters["joint"] = joint
    return environment


def _text(text: str, /, **values: object) -> str:
    """A text of a page in the language of the request; %(name)s stands for values, %% for a percent sign."""
    return _filled(_(str(text)), values)


def _counted(one: str, many: str, count: int, /, **values: object) -> str:
    """A text that depends on a number, which it may name as %(num)s."""
    return _filled(language.ngettext(one, many, count), {"num": count, **values})


def _filled(text: str, values: dict[str, object]) -> str:
    return text % values if values else text.replace("%%", "%")


def render(
    site: Site,
    request: Request,
    template: str,
    *,
    visitor: Account | None = None,
    ticket: Ticket | None = None,
    status: int = 200,
    **values: object,
) -> Response:
    """One page, with the stop's state and the sentence that was kept for it.

    Args:
        site: The site.
        request: The request.
        template: Its file.
        visitor: Who looks, None where nobody is signed in.
        ticket: Their sign-in.
        status: HTTP status.
        values: What the template shows.
    """
    if visitor is not None:
        site.clinic.presentation.language()  # what another station set is taken up
    notice = site.seal.read_notice(request.cookies.get("rehab_notice"))
    html = site.templates.get_template(template).render(
        visitor=visitor,
        form_token="" if ticket is None else site.seal.form_token(ticket),
        stopped=bool(site.clinic.live.snapshot().stop_source),
        path=request.url.path,
        idle_s=0 if visitor is None or visitor.role == "patient" else site.clinic.accounts.sign_ins.idle_s(),
        notice=notice,
        outbox=site.clinic.outbox.state(),
        version=site.clinic.version,
        language=spoken(),
        languages=LANGUAGES,
        **values,
    )
    answer = HTMLResponse(html, status)
    if notice is not None:
        secure = request.url.scheme == "https"
        answer.delete_cookie("rehab_notice", httponly=True, samesite="strict", secure=secure)
    return answer


def exercise(name: str) -> str:
    """An exercise in words."""
    return _(EXERCISES.get(name, name.replace("_", " ")))


def joint(name: str) -> str:
    """A joint in words: Index MCP flexion."""
    digit, *rest = name.split("_")
    words = (_(JOINT_WORDS.get(part, part.upper())) for part in rest)
    return " ".join((_(digit).capitalize(), *words))


def role(name: Role) -> str:
    """A role in words."""
    return _(ROLE_WORDS[name])


def mode(name: str) -> str:
    """A therapy mode in words."""
    return _(MODES.get(name, name))


def day(text: str) -> str:
    """An ISO date as people write it: 14 March 1957."""
    if not text:
        return _("not noted")
    return format_date(date.fromisoformat(text), "d MMMM y", locale=spoken())


def moment(utc_ns: int) -> str:
    """A time of recording in the clinic's own time zone: 22 Nov 2026, 11:58."""
    read = datetime.fromtimestamp(utc_ns // 1_000_000_000, tz=UTC).astimezone()
    return format_datetime(read, "d MMM y, HH:mm", tzinfo=read.tzinfo, locale=spoken())


def clock(utc_ns: int) -> str:
    """A time of today in the clinic's own time zone: 14:05."""
    return f"{datetime.fromtimestamp(utc_ns // 1_000_000_000, tz=UTC).astimezone():%H:%M}"


def instant(utc_ns: int) -> str:
    """The same for machines, ISO 8601."""
    return datetime.fromtimestamp(utc_ns // 1_000_000_000, tz=UTC).isoformat()
