"""Motors, straps and sensors of a simulated device for one tick as machine code.

Constants stand here and not beside the classes: what is compiled is kept on disk until this file changes.
Everything is done in place, in arrays that the callers made once.
"""

from __future__ import annotations

import math

from robot_iface.compiled import compiled
from robot_iface.types import Float64, Int64

STRAP_STIFFNESS_NM_RAD = 5.0
STRAP_DAMPING_NMS_RAD = 0.02
STRAP_AXIAL_N_M = 1000.0  # a cuff on skin, along the bone (assumed: 1 N/mm)
SLIP_S = 0.3  # a strap does not slip at once

# rows of what a motor is told
GOAL, GOAL_SPEED, STIFFNESS, DAMPING, FEED_FORWARD = range(5)
# rows of what a joint's sensors make of the truth: a sign, a zero error
SIGN, ZERO = range(2)
# columns of a strap
DORSAL, DISTAL, ALONG, SKIN, SLIP, SLIP_AT = range(6)


@compiled
def motor_torque(
    q: Float64, dq: Float64, at: Int64, motors: Float64, sensors: Float64, cap_nm: float, out: Float64
) -> None:
    """The device's own impedance loop on its own sensors, within its motors' cap.

    Args:
        q: All positions of the model, (nq,).
        dq: All speeds, (nq,).
        at: Where the J joints stand in them, (J,).
        motors: What the motors are told, (5, J).
        sensors: Sign and zero error of the joints' sensors, (2, J).
        cap_nm: The motors' cap.
        out: Receives the torques, (J,).
    """
    for j in range(at.size):
        seen = sensors[SIGN, j] * q[at[j]] + sensors[ZERO, j]
        speed = sensors[SIGN, j] * dq[at[j]]
        torque = (
            motors[FEED_FORWARD, j]
            + motors[STIFFNESS, j] * (motors[GOAL, j] - seen)
            + motors[DAMPING, j] * (motors[GOAL_SPEED, j] - speed)
        )
        out[j] = min(max(torque, -cap_nm), cap_nm)


@compiled
def strap_geometry(angle: float, strap: Float64) -> tuple[float, float, float, float]:
    """Where a strap on a link that turns about an offset axis leads the bone.

    In the plane of flexion (x palmar, z distal) the bone's joint is the origin and the link's axis stands at
    A = (-dorsal, distal). The cuff was donned at P = (-skin, along) of the bone, on the link at P - A. Turned
    by the link's angle it is at C = A + R (P - A). A bone whose skin lies on C at the height ``skin`` has the
    angle q* = atan2(C_x, C_z) + asin(skin / |C|), and the cuff stands sqrt(|C|^2 - skin^2) along it: it has
    slid. Without offset q* is the link's angle and nothing slides.

    Returns:
        Bone angle q*, dq*/dangle, slide in m, dslide/dangle.
    """
    dorsal, distal, along, skin = strap[DORSAL], strap[DISTAL], strap[ALONG], strap[SKIN]
    cos, sin = math.cos(angle), math.sin(angle)
    arm_x, arm_z = dorsal - skin, along - distal
    turned_x, turned_z = cos * arm_x + sin * arm_z, cos * arm_z - sin * arm_x
    x, z = turned_x - dorsal, turned_z + distal
    square = x * x + z * z
    reach = math.sqrt(square - skin * skin)
    # the cuff's velocity per unit of angle is (turned_z, -turned_x)
    outward = x * turned_z - z * turned_x
    bone = math.atan2(x, z) + math.atan2(skin, reach)
    turn = (z * turned_z + x * turned_x) / square - skin * outward / (reach * square)
    return bone, turn, reach - along, outward / reach


@compiled
def slipped(strap: Float64, t_s: float) -> float:
    """By how much a strap has slipped until now, rad: smoothly, within ``SLIP_S``."""
    part = min(max((t_s - strap[SLIP_AT]) / SLIP_S, 0.0), 1.0)
    return strap[SLIP] * part * part * (3.0 - 2.0 * part)


@compiled
def strap_load(
    link: float, link_speed: float, bone: float, bone_speed: float, strap: Float64, t_s: float
) -> tuple[float, float, float]:
    """The load in a strap, from its energy U = k d^2 / 2 + k_a h s d + k_a s^2 / 2.

    d = q* - slip - q is the strain across the bone, s the slide along it, h the height of the skin over the
    bone; k holds the k_a h^2 of the pull on the skin.

    Returns:
        Torque on the bone's joint; torque of the link on the world about its own axis, which is what a sensor
        there feels; length at which a spring of stiffness k between the two joints has the strain d.
    """
    leads, turn, slide, sliding = strap_geometry(link, strap)
    slip = slipped(strap, t_s)
    strain = leads - slip - bone
    drag = STRAP_AXIAL_N_M * (slide + strap[SKIN] * strain)
    across = STRAP_STIFFNESS_NM_RAD * strain + STRAP_AXIAL_N_M * strap[SKIN] * slide
    if strap[DORSAL] == 0.0 and strap[DISTAL] == 0.0:  # rounding must not make a slide
        strain = link - slip - bone
        across, turn, sliding, leads = STRAP_STIFFNESS_NM_RAD * strain, 1.0, 0.0, link
    damping = STRAP_DAMPING_NMS_RAD * (link_speed - bone_speed)
    return across + damping, across * turn + drag * sliding + damping, link - leads + slip


@compiled
def push(
    q: Float64,
    dq: Float64,
    places: Int64,
    motors: Float64,
    sensors: Float64,
    straps: Float64,
    t_s: float,
    cap_nm: float,
    muscles: Float64,
    torque: Float64,
    force: Float64,
    lengths: Float64,
) -> None:
    """Everything that pushes in the coming period: motors, muscles, and the straps between them.

    A strap's spring itself stays inside the solver. Its rest length carries offset and slip to it; a lever
    arm that is not one, and the drag of a strap that slides, are added to the forces.

    Args:
        q: All positions of the model, (nq,).
        dq: All speeds, (nq,).
        places: Where the links' and the bones' J joints stand in them, (2, J).
        motors: What the motors are told, (5, J).
        sensors: Sign and zero error of the joints' sensors, (2, J).
        straps: One row each, (J, 6).
        t_s: Time.
        cap_nm: The motors' cap.
        muscles: Torque of the patient's muscles, (J,).
        torque: Receives the motors' torques, (J,).
        force: Receives the applied forces of the model, (nq,).
        lengths: Receives rest lengths of the model's tendons, of which the straps are the first, (nt, 2).
    """
    motor_torque(q, dq, places[0], motors, sensors, cap_nm, torque)
    for j in range(places.shape[1]):
        link, bone = q[int(places[0, j])], q[int(places[1, j])]
        on_bone, on_world, length = strap_load(link, 0.0, bone, 0.0, straps[j], t_s)
        lengths[j, 0] = lengths[j, 1] = length
        spring = STRAP_STIFFNESS_NM_RAD * (link - bone - length)
        force[places[0, j]] = torque[j] + spring - on_world
        force[places[1, j]] = muscles[j] + on_bone - spring


@compiled
def sense(
    q: Float64,
    dq: Float64,
    places: Int64,
    straps: Float64,
    t_s: float,
    sensors: Float64,
    noise: Float64,
    out: Float64,
) -> None:
    """What the device's sensors read: first and second position, speed, interaction torque.

    Args:
        q: All positions of the model, (nq,).
        dq: All speeds, (nq,).
        places: Where the links' and the bones' J joints stand in them, (2, J).
        straps: One row each, (J, 6).
        t_s: Time.
        sensors: Sign and zero error of the joints' sensors, (2, J).
        noise: Noise of the first three, (3, J).
        out: Receives the readings, (4, J).
    """
    for j in range(places.shape[1]):
        at, bone_at = int(places[0, j]), int(places[1, j])
        angle, speed, bone, bone_speed = q[at], dq[at], q[bone_at], dq[bone_at]
        out[0, j] = sensors[SIGN, j] * angle + sensors[ZERO, j] + noise[0, j]
        out[1, j] = sensors[SIGN, j] * angle + noise[1, j]
        out[2, j] = sensors[SIGN, j] * speed + noise[2, j]
        out[3, j] = strap_load(angle, speed, bone, bone_speed, straps[j], t_s)[1]


@compiled
def sense_bare(
    q: Float64, dq: Float64, at: Int64, pushed: Float64, sensors: Float64, noise: Float64, out: Float64
) -> None:
    """What the sensors of a hand that nobody wears read; the torque sensor feels what pushes the joint.

    Args:
        q: All positions of the model, (nq,).
        dq: All speeds, (nq,).
        at: Where the J joints stand in them, (J,).
        pushed: Torque from outside on the joints, (J,).
        sensors: Sign and zero error of the joints' sensors, (2, J).
        noise: Noise of first and second position and speed, (3, J).
        out: Receives the readings, as ``sense``, (4, J).
    """
    for j in range(at.size):
        angle, speed = sensors[SIGN, j] * q[at[j]], sensors[SIGN, j] * dq[at[j]]
        out[0, j] = angle + sensors[ZERO, j] + noise[0, j]
        out[1, j] = angle + noise[1, j]
        out[2, j] = speed + noise[2, j]
        out[3, j] = -pushed[j]
