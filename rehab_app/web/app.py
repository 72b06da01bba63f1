"""The whole web application."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from importlib import resources

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute

from rehab_app.access import RateLimit, Verb
from rehab_app.config import ClinicFolder
from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.clinic import Clinic
from rehab_app.web import health, metrics_page, stop
from rehab_app.web.access_routes import access_routes
from rehab_app.web.gateway import picture, wire
from rehab_app.web.gateway.client_page import ClientPages
from rehab_app.web.guard import Guard, own_names
from rehab_app.web.language import _
from rehab_app.web.library_routes import library_routes
from rehab_app.web.meters import Meters
from rehab_app.web.pages import (
    backup,
    choices,
    entry,
    languages,
    live,
    live_run,
    marker_names,
    next_step,
    patient_data,
    recordings,
    reports,
    runner,
)
from rehab_app.web.patient_routes import patient_routes
from rehab_app.web.presence import present
from rehab_app.web.remember import Remembered
from rehab_app.web.render import page_templates, render
from rehab_app.web.signing import Seal, clinic_key
from rehab_app.web.site import Site, Viewports
from rehab_app.web.static_files import Static
from rehab_app.web.telemetry import Telemetry
from rehab_app.web.viewport import PAIRED
from rehab_app.web.visit import Visit, action, page

_TRIES = 20
_TRIES_WINDOW_S = 60.0


def create_app(
    clinic: Clinic, host: str = "127.0.0.1", open_viewports: Callable[[Clinic], Viewports] | None = None
) -> Starlette:
    """The shell and the gateway around one clinic.

    Args:
        clinic: The clinic.
        host: Address that the server listens on, one of the names that it answers to.
        open_viewports: Makes the viewports; by default the real ones.
    """
    site = Site(
        clinic=clinic,
        seal=Seal(clinic_key(ClinicFolder(clinic.folder).secret)),
        templates=page_templates(),
        viewports=(open_viewports or _real_viewports)(clinic),
        sign_in_limit=RateLimit(_TRIES, _TRIES_WINDOW_S, time.monotonic),
        accounts=Remembered(clinic.accounts.account, 2.0),
        patients=Remembered(clinic.patients.get, 10.0),
    )

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncGenerator[None]:
        del app
        warm = asyncio.create_task(_warm(site))
        yield
        await warm
        await run_in_threadpool(site.viewports.close)

    meters = Meters(clinic)
    meters.watch(
        "rehab_uploads_waiting",
        "Recordings that wait for the object store.",
        lambda: float(clinic.uploads.waiting()),
    )
    app = Starlette(
        routes=_routes(),
        middleware=_middleware(clinic, meters, host),
        lifespan=lifespan,
        exception_handlers={404: _not_found, NoAnswer: _failed, 500: _failed},
    )
    app.state.site = site
    app.state.meters = meters
    app.state.doctor = health.Doctor(clinic)
    return app


def _middleware(clinic: Clinic, meters: Meters, host: str) -> list[Middleware]:
    clinic.presentation.language()  # known before the first page; the guard waits for no data base
    return [
        Middleware(Telemetry, meters=meters),
        Middleware(Guard, hosts=own_names(host), usual_language=lambda: clinic.presentation.usual_language),
    ]


async def _warm(site: Site) -> None:
    """Start the live picture before anybody asks for it; where it cannot start, its page will say so."""
    with contextlib.suppress(Refused):
        await run_in_threadpool(site.viewports.live_port)


def _routes() -> list[BaseRoute]:
    return [
        *_entry_routes(),
        *access_routes(),
        *_live_routes(),
        *patient_routes(),
        *_privacy_routes(),
        *library_routes(),
        *_record_routes(),
        *_progress_routes(),
        *_gateway_routes(),
    ]


def _entry_routes() -> list[BaseRoute]:
    return [
        Route("/", entry.start),
        Route("/sign-in", entry.sign_in_page, methods=["GET"]),
        Route("/sign-in", entry.sign_in, methods=["POST"]),
        Route("/set-up", entry.set_up_page, methods=["GET"]),
        Route("/set-up", entry.set_up, methods=["POST"]),
        Route("/sign-out", action(entry.sign_out, "stop", "/"), methods=["POST"]),
        Route("/language", languages.choose, methods=["POST"]),
        Route("/stop", stop.press, methods=["POST"]),
        Route("/stop/state", stop.state, methods=["GET"]),
        Route("/healthz", health.ready, methods=["GET"]),
        Route("/healthz/live", health.live, methods=["GET"]),
        Route("/metrics", metrics_page.metrics, methods=["GET"]),
        Route("/stop/clear", action(stop.clear, "clear_stop", "/"), methods=["POST"]),
        Mount("/static", Static(directory=str(resources.files("web_assets") / "static"))),
    ]


def _live_routes() -> list[BaseRoute]:
    def does(name: str, answer: Callable[[Visit], Response], verb: Verb) -> BaseRoute:
        return Route(f"/live/{name}", action(answer, verb, "/live"), methods=["POST"])

    return [
        Route("/live", page(live.live), methods=["GET"]),
        Route("/live/takes", page(choices.takes), methods=["GET"]),
        Route("/live/patients", page(choices.patients), methods=["GET"]),
        Route("/live/cameras", page(live.cameras, "record"), methods=["GET"]),
        does("beat", live.beat, "view"),
        does("record", live.record, "record"),
        does("finish", live.finish, "record"),
        Route("/live/limits", page(live_run.limits), methods=["GET"]),
        does("play", live_run.play, "play"),
        does("measure", live_run.measure, "play"),
        does("fit", live_run.fit, "play"),
        does("tone", live_run.tone, "play"),
        does("tracking", live_run.tracking, "play"),
        does("pause", live_run.pause, "stop"),
        does("resume", live_run.resume, "play"),
        does("reverse", live_run.reverse, "play"),
        does("next", live_run.advance, "play"),
        does("speed", live_run.speed, "stop"),
        does("target", live.target, "play"),
        does("pain", runner.pain, "stop"),
        does("operate", runner.operate, "play"),
        does("session/begin", runner.begin, "play"),
        does("session/step", runner.step, "play"),
        does("session/check-in", runner.check_in, "note"),
        does("session/start", runner.start, "play"),
        does("session/end", runner.end, "note"),
        Route("/live/session/choices", page(runner.choices), methods=["GET"]),
        Route("/live/session/note", page(runner.note, "note"), methods=["GET"]),
    ]


def _privacy_routes() -> list[BaseRoute]:
    def does(path: str, answer: Callable[[Visit], Response], verb: Verb, back: str) -> BaseRoute:
        return Route(path, action(answer, verb, back), methods=["POST"])

    home, one = backup.PAGE, "/patients/{patient}/data"
    return [
        Route(home, page(backup.backup, "backup"), methods=["GET"]),
        does(home + "/passphrase", backup.set_passphrase, "backup", home),
        does(home + "/place", backup.set_place, "backup", home),
        does(home + "/make", backup.make, "backup", home),
        does(home + "/restore", backup.restore, "backup", home),
        does(home + "/retention", backup.set_retention, "erase", home),
        Route(home + "/file/{name}", page(backup.download, "backup"), methods=["GET"]),
        Route(one, page(patient_data.data), methods=["GET"]),
        does(one + "/consent", patient_data.state_consent, "note", "/patients"),
        does(one + "/images", patient_data.remove_images, "erase", "/patients"),
        does(one + "/export", patient_data.export, "export", "/patients"),
        does(one + "/erase", patient_data.erase, "erase", "/patients"),
    ]


def _record_routes() -> list[BaseRoute]:
    routes: list[BaseRoute] = [
        Route("/takes/{recording}/names", page(marker_names.names, "record"), methods=["GET"]),
        Route(
            "/takes/{recording}/names", action(marker_names.track_again, "record", "/takes"), methods=["POST"]
        ),
        Route("/takes/{recording}/first.jpg", page(marker_names.picture, "record"), methods=["GET"]),
        Route("/sessions", page(recordings.sessions), methods=["GET"]),
        Route("/sessions/{recording}", page(recordings.session), methods=["GET"]),
    ]
    for kind in ("takes", "sessions"):
        routes += [
            Route(f"/{kind}/{{recording}}/report", page(recordings.report), methods=["GET"]),
            Route(f"/{kind}/{{recording}}/report.html", page(recordings.report_html), methods=["GET"]),
            Route(f"/{kind}/{{recording}}/report.json", page(recordings.report_json), methods=["GET"]),
            Route(f"/{kind}/{{recording}}/report.{{format}}", page(reports.download), methods=["GET"]),
        ]
    return routes


def _progress_routes() -> list[BaseRoute]:
    return [
        Route("/patients/{patient}/progress", page(reports.progress), methods=["GET"]),
        Route("/patients/{patient}/progress.{format}", page(reports.progress_file), methods=["GET"]),
        Route("/patients/{patient}/compare", page(reports.compare), methods=["GET"]),
        Route("/patients/{patient}/compare.{format}", page(reports.compare_file), methods=["GET"]),
        Route("/patients/{patient}/next", page(next_step.next_step), methods=["GET"]),
        Route(
            "/patients/{patient}/next", action(next_step.answer, "prescribe", "/patients"), methods=["POST"]
        ),
        Route("/patients/{patient}/aim", action(next_step.aim, "prescribe", "/patients"), methods=["POST"]),
    ]


def _gateway_routes() -> list[BaseRoute]:
    pages = ClientPages()
    look_live, look_review = picture.endpoint(pages, _live_port), picture.endpoint(pages, _review_port)
    # The live picture is shared, so only those who may play move its controls; a review harms nobody.
    hear_live, hear_review = wire.endpoint(_live_port, "play"), wire.endpoint(_review_port, "view")
    return [
        Route("/live/view/", look_live, methods=["GET"]),
        Route("/review/{recording}/view/", look_review, methods=["GET"]),
        WebSocketRoute("/live/view", hear_live),
        WebSocketRoute("/review/{recording}/view", hear_review),
    ]


def _live_port(site: Site, recording: str) -> int:
    del recording
    return site.viewports.live_port()


def _review_port(site: Site, recording: str) -> int:
    named = [recordings.catalogue_id(one) for one in recording.split(PAIRED, 1)]
    return site.viewports.review_port(PAIRED.join(named))


def _real_viewports(clinic: Clinic) -> Viewports:
    from rehab_app.web.screens import Screens

    return Screens(clinic)


def _not_found(request: Request, problem: Exception) -> Response:
    """A page like every other, with the stop on it."""
    del problem
    site: Site = request.app.state.site
    there = present(site, request)
    visitor, ticket = (None, None) if there is None or there.locked else (there.account, there.ticket)
    sentence = _("There is no page %(path)s: go back to the start.") % {"path": request.url.path}
    return render(
        site, request, "refused.html.j2", visitor=visitor, ticket=ticket, status=404, sentence=sentence
    )


def _failed(request: Request, problem: Exception) -> Response:
    """The same for what went wrong here; it asks no data base, which may be what failed."""
    sentence, status = _("This page failed; the server's log says why. The stop still works."), 500
    if isinstance(problem, NoAnswer):
        sentence, status = str(problem), 503
    return render(request.app.state.site, request, "refused.html.j2", status=status, sentence=sentence)
