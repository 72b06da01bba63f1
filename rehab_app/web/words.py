"""Words on the screen for the names in files."""

from __future__ import annotations

from rehab_app.services.exercises import STARTERS

MODES = {
    "passive": "Passive (CPM)",
    "assistive": "Active-assisted",
    "transparent": "Active (transparent)",
    "resistive": "Resisted",
}
ROBOTS = {
    "exoskeleton": "Exoskeleton (simulation)",
    "dlr-hit-ii": "DLR-HIT-Hand II (simulation)",
}
SPACES = {"joint": "at the joints", "fingertip": "at the fingertips"}
EXERCISES = {
    **{one.name: one.words for one in STARTERS},
    "open_close": "Hand opening and closing",
    "index_pip": "Index PIP flexion",
    "tapping": "Finger tapping",
    "pinch": "Tip pinch",
    "spread": "Finger abduction (spread)",
    "still": "Hold still",
    "range of motion sweep": "Today's range, measured",
    "fit check": "Fit check",
    "tone at three speeds": "Tone at three speeds",
}
TWINS = {
    "healthy": "Healthy",
    "flaccid": "Flaccid",
    "weak": "Weak",
    "mas1+": "Spastic, MAS 1+",
    "mas2": "Spastic, MAS 2",
    "mas3": "Spastic, MAS 3",
    "contracture": "Contracture",
    "tremor": "Tremor",
    "clonus": "Clonus",
    "slacking": "Slacking",
    "resisting": "Resisting",
    "tiring": "Tiring",
}
PHASES = {
    "approach": "Moving to the start",
    "ramp": "Speeding up",
    "cue": "Waiting for the patient",
    "move": "Target movement",
    "hold": "Holding the target",
    "return": "Returning",
    "rest": "Rest",
    "stopped": "Stopped",
    "done": "Finished",
    "open": "Open hand",
    "tabletop": "Tabletop",
    "hook": "Hook fist",
    "fist": "Full fist",
    "check": "Joint by joint",
    "fold": "Bending to the start",
    "stretch": "Stretch at one speed",
    "rest-proposed": "Rest of a minute",
    "skin-check": "Look at the skin",
}
STATES = {
    "idle": "Ready",
    "countdown": "Get ready",
    "recording": "Recording",
    "processing": "Processing",
    "rehearsing": "Rehearsing",
    "playing": "Playing",
    "stopped": "Stopped",
    "done": "Done",
    "failed": "Failed",
}
ASKED = {
    "cue": "Cue the patient: it is their turn.",
    "rest-proposed": "The hand is tiring: let it rest for a minute, or end the rest.",
    "skin-check": "Look at the skin, then go on.",
}
"""What a phase asks of the therapist."""
RUNS = {"therapy": "Playing", "range": "Measuring", "fit": "Checking fit"}
NEXT = {
    "cue": "Help now",
    "hold": "End the hold",
    "rest": "Next repetition now",
    "rest-proposed": "End the rest",
}
"""What comes next in therapy, by phase; in every other phase there is nothing to be asked for."""
