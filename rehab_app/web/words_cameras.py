"""What pages say of cameras: states, names and remedies, whose English the cameras themselves say."""

from __future__ import annotations

import re

from rehab_app.web.language import _, marked

STATES = {"ready": marked("Ready"), "busy": marked("In use"), "unavailable": marked("Not usable")}
LABELS = (
    marked("Virtual camera"),
    marked("Kinect (first generation)"),
    marked("OpenNI camera (Xtion, PrimeSense)"),
)
"""Names that are words; the others are those of makers."""
REMEDIES = (
    marked("End the other recording first."),
    marked("Run pip install %(package)s."),
    marked("Install it (Debian: sudo apt-get install %(package)s)."),
    marked("Its driver fails: unplug the %(kind)s camera, plug it in again and look again."),
)
"""Sentences of the cameras' listing; %(name)s stands for what is a name in every language."""
_NAMED = re.compile(r"%\\\((\w+)\\\)s")


def camera_label(label: str) -> str:
    """A camera's name in the language of the page; that of a maker as it is."""
    return _(label)


def camera_remedy(remedy: str) -> str:
    """What to do about a camera, in the language of the page; a sentence that nobody knows stays as it is."""
    for sentence in REMEDIES:
        found = _pattern(sentence).fullmatch(remedy)
        if found is not None:
            return _(sentence) % found.groupdict() if found.groupdict() else _(sentence)
    return remedy


def _pattern(sentence: str) -> re.Pattern[str]:
    """The sentence with a name wherever one stands in for it."""
    return re.compile(_NAMED.sub(lambda found: f"(?P<{found[1]}>.+)", re.escape(sentence)))
