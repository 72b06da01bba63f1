"""What the clinic measures and moves with: cameras, robots, their last fit checks, boards to print."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.calibrations import Calibrations
from robot_iface.types import Capabilities
from sessions.catalogue import CameraCalibration, Catalogue, FitCheck

if TYPE_CHECKING:
    from rehab_app.cameras import CameraListing

_LOOKED_THROUGH = 40
"""Patients of the newest sessions among whom the last fit check is looked for."""
BOARD_KINDS = ("pdf", "svg")


@dataclass(frozen=True, slots=True)
class CameraState:
    """A camera with its newest calibration.

    Attributes:
        listing: What it is and whether it may be used.
        calibration: Its newest calibration, None where it has none.
    """

    listing: CameraListing
    calibration: CameraCalibration | None


@dataclass(frozen=True, slots=True)
class RobotState:
    """A robot, simulated or real.

    Attributes:
        name: Its name.
        capabilities: What it is and can do; None where its device file says something that cannot be.
        fault: The sentence about that file, empty where there is none.
        last_fit: The last fit check of it, None where none is known.
    """

    name: str
    capabilities: Capabilities | None
    fault: str
    last_fit: FitCheck | None


class Devices:
    """Cameras and robots of this machine; nothing is opened or powered.

    Args:
        catalogue: Where fit checks are kept.
        calibrations: Calibrated cameras.
    """

    def __init__(self, catalogue: Catalogue, calibrations: Calibrations) -> None:
        self._catalogue = catalogue
        self._calibrations = calibrations

    def cameras(self) -> tuple[CameraState, ...]:
        """Every camera that the machine knows of, each with its newest calibration."""
        from rehab_app.cameras import list_cameras

        newest: dict[str, CameraCalibration] = {}
        for row in self._calibrations.list():
            newest.setdefault(row.camera, row)
        return tuple(CameraState(one, newest.get(one.id)) for one in list_cameras())

    def robots(self) -> tuple[RobotState, ...]:
        """The simulations, then every device file."""
        from robot_iface.build import DEVICES, device_names  # loads the physics: only where it is needed

        return tuple(self._robot(name) for name in (*DEVICES, *device_names()))

    def advice(self) -> tuple[str, ...]:
        """What a real hand needs on this machine, one sentence each."""
        from robot_iface.build import real_device_advice

        return tuple(real_device_advice())

    def board(self, kind: str) -> bytes:
        """A calibration board to print at its true size, as a file of that kind.

        Args:
            kind: One of BOARD_KINDS.

        Raises:
            Refused: There is no such kind.
        """
        if kind not in BOARD_KINDS:
            raise Refused("board file", repr(kind[:20]), "one of " + ", ".join(BOARD_KINDS), "choose one")
        from rehab_app.calibration import parse_board
        from rehab_app.calibration.board_print import draw_board, write_board

        drawing = draw_board(parse_board("9x6", 0.025, None, "4x4_50"), "")
        with tempfile.TemporaryDirectory(prefix="board-") as folder:
            target = Path(folder) / f"board.{kind}"
            write_board(drawing, target)
            return target.read_bytes()

    def _robot(self, name: str) -> RobotState:
        from robot_iface.build import capabilities

        try:
            able, fault = capabilities(name), ""
        except REFUSALS as refusal:
            able, fault = None, str(refusal)
        return RobotState(name, able, fault, self._last_fit(name))

    def _last_fit(self, device: str) -> FitCheck | None:
        """The newest fit check among the patients who were treated last."""
        found = [
            rows[0]
            for patient in self._catalogue.lately_treated()[:_LOOKED_THROUGH]
            if (rows := self._catalogue.fit_checks(patient, device))
        ]
        return max(found, key=lambda row: row.created_utc_ns, default=None)
