"""A camera's own clock told in the machine's monotonic time."""

from __future__ import annotations

_GROWTH = 1e-4  # crystals differ by less than this share; the offset may follow that much
_FALL = 0.2  # the first images often come late: what they were thought to be is corrected over some images
_GAP_MAX_NS = 10_000_000_000


class DeviceClock:
    """Maps capture times of a device to monotonic time.

    A capture cannot arrive before it was made, so that the smallest delay met is the best offset known. The
    offset is let grow slowly, because two crystals drift, and fall gently, so that the spacing of captures
    stays the device's own.
    """

    def __init__(self) -> None:
        self._offset_ns: int | None = None
        self._device_ns = 0
        self._last_ns: int | None = None

    def monotonic_ns(self, device_ns: int, now_ns: int) -> int:
        """Capture time in monotonic ns, strictly rising from call to call.

        Args:
            device_ns: Time of capture by the device's clock, ns; its zero does not matter.
            now_ns: Monotonic time of arrival, ns.
        """
        passed_ns = device_ns - self._device_ns
        arrival = now_ns - device_ns
        if self._offset_ns is None or not 0 <= passed_ns < _GAP_MAX_NS:
            self._offset_ns = arrival  # the device started anew
        else:
            lowest, highest = (self._offset_ns + round(share * passed_ns) for share in (-_FALL, _GROWTH))
            self._offset_ns = min(max(arrival, lowest), highest)
        self._device_ns = device_ns
        t_ns = device_ns + self._offset_ns
        self._last_ns = t_ns if self._last_ns is None else max(t_ns, self._last_ns + 1)
        return self._last_ns
