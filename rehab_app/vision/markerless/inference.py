"""One network on one thread; the only place that knows the library that runs it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.markerless.networks import Network
from sessions.errors import Refused
from sessions.records.fields import Float64

Picture = NDArray[np.float32]
"""A network's input: RGB, 0 to 1, shape (S, S, 3)."""


class Inference:
    """Runs a network with one input and several outputs.

    Args:
        network: Which one it is, for words.
        content: Its file.

    Raises:
        Refused: The library is not installed (the extra ``markerless``), or cannot read the file.
    """

    def __init__(self, network: Network, content: bytes) -> None:
        try:
            from ai_edge_litert.interpreter import Interpreter
        except ImportError as error:
            raise Refused(
                "markerless tracking",
                "without its library ai-edge-litert",
                "the extra 'markerless'",
                "run pip install 'rehab-app[markerless]'",
            ) from error
        try:
            self._interpreter: Any = Interpreter(model_content=content, num_threads=1)
            self._interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as error:
            raise Refused(
                f"network for {network.name}", f"unreadable ({error})", network.file, "install it again"
            ) from error
        (given,) = self._interpreter.get_input_details()
        self.side_px = int(given["shape"][1])
        self._input: int = given["index"]
        self._outputs: dict[str, int] = {
            str(output["name"]): output["index"] for output in self._interpreter.get_output_details()
        }

    def __call__(self, picture: Picture) -> dict[str, Float64]:
        """The outputs by name, without the batch axis, for one picture (side, side, 3)."""
        self._interpreter.set_tensor(self._input, picture[None])
        self._interpreter.invoke()
        return {
            name: np.asarray(self._interpreter.get_tensor(index)[0], dtype=np.float64)
            for name, index in self._outputs.items()
        }
