"""What ``rehab-app grasp`` makes: takes of a grasp, trials of reaching for one, the thesis reproduced."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.grasp.posture import Posture
    from rehab_app.grasp.spiral import GraspPath


def write_take(output: Output, file: Path, posture: Posture, way: GraspPath) -> dict[str, Any]:
    """Make a take of a grasp; what to say of it, as JSON."""
    from rehab_app import __version__
    from rehab_app.grasp.target_json import StoredTarget
    from rehab_app.recording.grasp_take import write_grasp_take
    from rehab_app.services.grip_target import GripChoice

    words = GripChoice(posture.thing, posture.grip).words
    target = StoredTarget(posture.thing, posture.grip, dict(posture.angles_rad))
    sealed = write_grasp_take(
        file, way, posture.hand, exercise=words, software_version=__version__, target=target
    )
    output.say(f"Take: {sealed.path}. Approve it with: rehab-app approve {sealed.path} --by NAME")
    return {"take": sealed.path, "sha256": sealed.sha256}


def reach(output: Output, radius_m: float, plot: Path | None) -> None:
    """Let the simulated arm and hand reach for a cylinder and hold it."""
    from rehab_app.grasp.reach import reach_for
    from rehab_app.services.reports import write_whole
    from robot_iface.build import draw_reach

    reached = reach_for(radius_m)
    grasp = reached.grasp
    if plot is not None:
        write_whole(plot, draw_reach(grasp).encode())
    holds = "holds" if grasp.holds else "does NOT hold"
    output.say(
        f"The hand {holds} the cylinder of {1e3 * radius_m:g} mm radius: "
        f"it moves {1e3 * reached.moved_m[0]:.1f} mm by its weight and {1e3 * reached.moved_m[1]:.1f} mm "
        f"under the worst of six pushes of 0.5 N, and turns {math.degrees(reached.turned_rad):.1f} deg."
    )
    output.say(f"  the arm stays within {1e3 * reached.arm_error_m[0]:.1f} mm of its way")
    output.result(
        {
            "radius_m": radius_m,
            "holds": grasp.holds,
            "moved_m": {"gravity": float(reached.moved_m[0]), "worst_push": float(reached.moved_m[1])},
            "turned_rad": reached.turned_rad,
            "arm_error_m": {"largest": float(reached.arm_error_m[0]), "end": float(reached.arm_error_m[1])},
            "link_force_n": grasp.link_force_n.tolist(),
            "palm_force_n": grasp.palm_force_n,
            "plot": plot,
        }
    )


def reproduce(output: Output, file: Path) -> None:
    """Write the thesis's tables and figures beside ours; pictures go beside the document."""
    from rehab_app.errors import Refused
    from rehab_app.grasp.thesis_document import thesis_document, thesis_pictures
    from rehab_app.services.reports import write_whole

    if file.suffix.lower() != ".md":
        raise Refused("--reproduce", str(file), "a file that ends in .md", "name the document so")
    text, pictures = thesis_document(), thesis_pictures()
    made = [file]
    write_whole(file, text.encode())
    for name, svg in pictures.items():
        picture = file.parent / name
        write_whole(picture, svg.encode())
        made.append(picture)
    for one in made:
        output.say(f"Made: {one}")
    output.result({"files": made})
