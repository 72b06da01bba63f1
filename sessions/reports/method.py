"""The last pages of a report: what each number means, its version, its limits, and where it comes from."""

from __future__ import annotations

from collections.abc import Iterable

from sessions.metrics import Lineage, Metric, Summary, definition
from sessions.records import SessionHeader
from sessions.reports.language import _, decimal, marked
from sessions.reports.ordered import ordered_blocks
from sessions.reports.paper import Block, Bullets, Heading, Hint, Words
from sessions.reports.remarks import remark
from sessions.reports.wording import span

_LIMITS = marked(
    "Intervals of errors take the measurement error of all samples as fully correlated; those of a range "
    "take its two ends as independent. They hold what the sensors state, not what they do not know (strap "
    "slip, skin movement). They end where the number itself ends: no time below 0, no share above 100 %%. "
    "Angles measured by %(sources)s. A camera cannot see markers under an exoskeleton."
)
_SMOOTHNESS = marked(
    "Smoothness is measured in the palm frame, stroke by stroke. Its reliability is known for arm movements "
    "only; the floor is what a perfectly smooth movement would score with this noise and frame rate."
)
_LIMITS_OF_THERAPY = (
    marked(
        "The robot's share comes from the interaction torque: recoil of stiff tissue and spasm look like "
        "effort."
    ),
    marked("A passive robot makes anyone look good: compare errors only at equal stiffness."),
)


def method_blocks(summary: Summary) -> tuple[Block, ...]:
    """Everything that somebody needs who doubts a number."""
    therapy = _LIMITS_OF_THERAPY if summary.header.kind == "therapy" else ()
    limits = [_(_LIMITS, sources=sources(summary)), *(_(text) for text in (_SMOOTHNESS, *therapy))]
    return (
        Heading(_("How it was measured")),
        definitions(item.name for item in summary.metrics),
        Heading(_("Limits of these numbers"), 3),
        Bullets(tuple(limits)),
        *ordered_blocks(summary.header),
        Heading(_("Where the numbers come from"), 3),
        Hint(_file(summary)),
        _lineages(summary.metrics, summary.header),
    )


def definitions(names: Iterable[str]) -> Words:
    """What each of these metrics means, and the version of its method."""
    known = [definition(name) for name in dict.fromkeys(names)]
    rows = tuple(
        (_(item.title), _(item.meaning), _("%(name)s, version %(n)s", name=item.name, n=item.version))
        for item in known
    )
    return Words((_("Number"), _("What it means"), _("Method")), rows)


def sources(summary: Summary) -> str:
    """What measured the file, such as "encoder"."""
    named = dict.fromkeys(item.lineage.source for item in summary.metrics if item.lineage.source)
    return ", ".join(remark(name) for name in named) or _("not recorded")


def _file(summary: Summary) -> str:
    header = summary.header
    parts = [
        _(
            "File SHA-256 %(digest)s, written by version %(version)s",
            digest=summary.sha256,
            version=header.software_version,
        )
    ]
    if header.marker_protocol:
        parts.append(_("marker protocol %(name)s", name=header.marker_protocol))
    if header.calibration_digest:
        parts.append(_("calibration %(digest)s", digest=header.calibration_digest))
    return ", ".join([*parts, *(_("made from %(digest)s", digest=parent) for parent in header.parents)])


def _lineages(metrics: tuple[Metric, ...], header: SessionHeader) -> Words:
    """Each different lineage once, with the names of the metrics that share it."""
    grouped: dict[Lineage, list[str]] = {}
    for item in metrics:
        names = grouped.setdefault(item.lineage, [])
        if item.name not in names:
            names.append(item.name)
    rows = tuple(
        (
            ", ".join(names),
            ", ".join(lineage.topics),
            _span(lineage, header.monotonic_start_ns),
            remark(lineage.source),
            remark(lineage.conditions) or "—",
        )
        for lineage, names in grouped.items()
    )
    return Words((_("Numbers"), _("Topics"), _("Time span (s)"), _("Source"), _("Conditions")), rows)


def _span(lineage: Lineage, start_ns: int) -> str:
    if not lineage.t_end_ns:
        return "—"
    first, last = ((t_ns - start_ns) / 1e9 for t_ns in (lineage.t_start_ns, lineage.t_end_ns))
    return span(decimal(f"{first:.2f}"), decimal(f"{last:.2f}"))
