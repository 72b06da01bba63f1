"""Words on the screen for the names in files."""

from __future__ import annotations

from rehab_app.services.exercises import STARTERS
from rehab_app.web.language import marked

MODES = {
    "passive": marked("Passive (CPM)"),
    "assistive": marked("Active-assisted"),
    "transparent": marked("Active (transparent)"),
    "resistive": marked("Resisted"),
}
ROBOTS = {
    "exoskeleton": marked("Exoskeleton (simulation)"),
    "dlr-hit-ii": marked("DLR-HIT-Hand II (simulation)"),
}
SPACES = {"joint": marked("at the joints"), "fingertip": marked("at the fingertips")}
JOINT_WORDS = {"flexion": marked("flexion"), "abduction": marked("abduction")}
"""Parts of a joint's name that are words; the others are written in capitals."""
EXERCISES = {
    **{one.name: one.words for one in STARTERS},
    "open_close": marked("Hand opening and closing"),
    "index_pip": marked("Index PIP flexion"),
    "tapping": marked("Finger tapping"),
    "pinch": marked("Tip pinch"),
    "spread": marked("Finger abduction (spread)"),
    "still": marked("Hold still"),
    "range of motion sweep": marked("Today's range, measured"),
    "fit check": marked("Fit check"),
    "tone at three speeds": marked("Tone at three speeds"),
}
SPOKEN = (
    marked("Straight fist"),
    marked("PIP blocking"),
    marked("DIP blocking"),
    marked("Single-finger flexion and extension"),
    marked("Place and hold"),
    marked("Thumb abduction"),
    marked("Thumb extension"),
    marked("Thumb opposition to each finger"),
    marked("Three-jaw pinch"),
    marked("Key pinch"),
    marked("Cylinder grasp and release"),
    marked("Wave"),
    marked("left"),
    marked("right"),
    marked("LEFT"),
    marked("RIGHT"),
)
"""Names that the services say: the starter exercises and the sides."""
TWINS = {
    "healthy": marked("Healthy"),
    "flaccid": marked("Flaccid"),
    "weak": marked("Weak"),
    "mas1+": marked("Spastic, MAS 1+"),
    "mas2": marked("Spastic, MAS 2"),
    "mas3": marked("Spastic, MAS 3"),
    "contracture": marked("Contracture"),
    "tremor": marked("Tremor"),
    "clonus": marked("Clonus"),
    "slacking": marked("Slacking"),
    "resisting": marked("Resisting"),
    "tiring": marked("Tiring"),
}
PHASES = {
    "approach": marked("Moving to the start"),
    "ramp": marked("Speeding up"),
    "cue": marked("Waiting for the patient"),
    "move": marked("Target movement"),
    "hold": marked("Holding the target"),
    "return": marked("Returning"),
    "rest": marked("Rest"),
    "stopped": marked("Stopped"),
    "done": marked("Finished"),
    "open": marked("Open hand"),
    "tabletop": marked("Tabletop"),
    "hook": marked("Hook fist"),
    "fist": marked("Full fist"),
    "check": marked("Joint by joint"),
    "fold": marked("Bending to the start"),
    "stretch": marked("Stretch at one speed"),
    "rest-proposed": marked("Rest of a minute"),
    "skin-check": marked("Look at the skin"),
}
STATES = {
    "idle": marked("Ready"),
    "countdown": marked("Get ready"),
    "recording": marked("Recording"),
    "processing": marked("Processing"),
    "rehearsing": marked("Rehearsing"),
    "playing": marked("Playing"),
    "stopped": marked("Stopped"),
    "done": marked("Done"),
    "failed": marked("Failed"),
}
ASKED = {
    "cue": marked("Cue the patient: it is their turn."),
    "rest-proposed": marked("The hand is tiring: let it rest for a minute, or end the rest."),
    "skin-check": marked("Look at the skin, then go on."),
}
"""What a phase asks of the therapist."""
RUNS = {
    "therapy": marked("Playing"),
    "range": marked("Measuring"),
    "fit": marked("Checking fit"),
    "tone": marked("Measuring"),
    "tracking": marked("Measuring"),
}
ASSESSED = {
    "range": marked("Today's range"),
    "fit": marked("Fit check"),
    "tone": marked("Tone at three speeds"),
    "tracking": marked("Target tracking"),
}
TOLD = {
    "fold": marked("Tell the patient: let your hand be moved, do not help. The fingers bend to the start."),
    "stretch": marked("Tell the patient: let your hand be moved, do not help. The fingers are stretched."),
    "rest": marked("Rest: the hand relaxes. The next stretch follows by itself."),
}
"""What the therapist says in a phase of the tone test."""
FOLLOW = marked("Tell the patient: follow the outlined hand with your own. The robot does not help.")
NEXT = {
    "cue": marked("Help now"),
    "hold": marked("End the hold"),
    "rest": marked("Next repetition now"),
    "rest-proposed": marked("End the rest"),
}
"""What comes next in therapy, by phase; in every other phase there is nothing to be asked for."""
