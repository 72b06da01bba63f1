"""Exercises of the starter library that open, close and bend the fingers [P: for a clinician to sign]."""

from __future__ import annotations

from rehab_app.services.exercise_records import Dose, Exercise, marked

_FINGERS = ("index", "middle", "ring", "little")
_REPAIR = marked("Not after a recent tendon repair unless the surgeon's protocol allows it.")
_TONE = marked("Where the fingers pull shut, go slowly; stop and let the hand rest if the pull grows.")
_PAIN = marked("Stop at pain: a stretch may be felt, it must not hurt.")

GLIDES = (
    Exercise(
        name="open_close",
        words=marked("Hand opening and closing"),
        purposes=("opening", "range"),
        purpose=marked("Open the whole hand, the movement that is lost first after a stroke."),
        instructions=(
            marked("Begin with the hand loosely closed."),
            marked("Open all fingers and the thumb as far as they go."),
            marked("Stay open for a moment, then let the hand close by itself."),
        ),
        joints=marked("Extension of all finger joints, thumb extension"),
        cautions=(_TONE, _PAIN),
        dose=Dose(repetitions=30, minutes=10.0, hold_s=2.0),
        start="loose",
        end="open",
    ),
    Exercise(
        name="straight_fist",
        words=marked("Straight fist"),
        purposes=("range",),
        purpose=marked("Let the superficial flexor tendons glide."),
        instructions=(
            marked("Begin with straight fingers."),
            marked("Bend the knuckles and the middle joints; keep the end joints straight."),
            marked("Bring the fingertips to the base of the palm, then straighten."),
        ),
        digits=_FINGERS,
        joints=marked("MCP and PIP flexion with a straight DIP"),
        cautions=(_REPAIR, _PAIN),
        start="open",
        end="straight fist",
    ),
    Exercise(
        name="hook_fist",
        words=marked("Hook fist"),
        purposes=("range",),
        purpose=marked("Let the two flexor tendons of each finger glide past each other."),
        instructions=(
            marked("Begin with straight fingers."),
            marked("Keep the knuckles straight and bend the middle and end joints to a hook."),
            marked("Straighten again."),
        ),
        digits=_FINGERS,
        joints=marked("PIP and DIP flexion with a straight MCP"),
        cautions=(_REPAIR, _PAIN),
        start="open",
        end="hook",
    ),
    Exercise(
        name="full_fist",
        words=marked("Full fist"),
        purposes=("range", "grasp"),
        purpose=marked("Bend every joint of the fingers together and reach the palm."),
        instructions=(
            marked("Begin with straight fingers."),
            marked("Close all joints until the fingertips touch the palm, the thumb outside and last."),
            marked("Hold, then open fully."),
        ),
        joints=marked("MCP, PIP and DIP flexion, thumb flexion"),
        cautions=(_REPAIR, marked("Keep the thumb outside the fist and the nails off the palm.")),
        dose=Dose(hold_s=2.0),
        start="open",
        end="fist",
    ),
    Exercise(
        name="tabletop",
        words=marked("Tabletop"),
        purposes=("range",),
        purpose=marked("Train the small muscles that bend the knuckles while the fingers stay straight."),
        instructions=(
            marked("Begin with straight fingers."),
            marked("Bend only the knuckles until the fingers point forward like a table top."),
            marked("Straighten again."),
        ),
        digits=_FINGERS,
        joints=marked("MCP flexion with straight PIP and DIP"),
        cautions=(_PAIN,),
        start="open",
        end="tabletop",
    ),
    Exercise(
        name="index_pip",
        words=marked("PIP blocking"),
        purposes=("fingers", "range"),
        purpose=marked("Bend the middle joint of one finger alone."),
        instructions=(
            marked("Hold the finger below its middle joint so that the knuckle stays straight."),
            marked("Bend the middle joint as far as it goes."),
            marked("Straighten it fully. The picture shows the index finger."),
        ),
        digits=("index",),
        joints=marked("PIP flexion and extension"),
        cautions=(_REPAIR, _PAIN),
        start="open",
        end="index pip bent",
    ),
    Exercise(
        name="dip_blocking",
        words=marked("DIP blocking"),
        purposes=("fingers", "range"),
        purpose=marked("Bend the end joint of one finger alone: the deep flexor tendon."),
        instructions=(
            marked("Hold the finger below its end joint so that the other joints stay straight."),
            marked("Bend the end joint."),
            marked("Straighten it fully. The picture shows the index finger."),
        ),
        digits=("index",),
        joints=marked("DIP flexion and extension"),
        cautions=(_REPAIR, _PAIN),
        start="open",
        end="index tip bent",
    ),
    Exercise(
        name="finger_flexion",
        words=marked("Single-finger flexion and extension"),
        purposes=("fingers", "dexterity"),
        purpose=marked("Move one finger while the others stay still."),
        instructions=(
            marked("Begin with the open hand."),
            marked("Bend one finger towards the palm; the others stay straight."),
            marked("Straighten it, then go to the next finger."),
        ),
        digits=("index",),
        joints=marked("MCP, PIP and DIP of one finger"),
        cautions=(_TONE, _PAIN),
        start="open",
        end="index bent",
    ),
    Exercise(
        name="place_and_hold",
        words=marked("Place and hold"),
        purposes=("range", "grasp"),
        purpose=marked("Hold a position with one's own strength after the hand was brought there."),
        instructions=(
            marked("Let the robot or the other hand bring the fingers to the fist."),
            marked("Hold the position by yourself while the help goes away."),
            marked("Let go and open the hand."),
        ),
        joints=marked("Flexors of all fingers, held without moving"),
        cautions=(_REPAIR, marked("Holds of a minute and more need lower torque limits.")),
        dose=Dose(repetitions=10, minutes=6.0, hold_s=10.0),
        start="open",
        end="loose",
    ),
)
