"""Ctrl-C in a session in real time presses stop: the hand is braked and the session sealed."""

from __future__ import annotations

import signal

from rehab_app.cli.therapy import _stop_on_interrupt


def test_the_first_interrupt_presses_stop_and_the_second_breaks_off() -> None:
    pressed: list[str] = []
    before = signal.getsignal(signal.SIGINT)
    try:
        _stop_on_interrupt(lambda: pressed.append("stop"))
        signal.raise_signal(signal.SIGINT)
        assert pressed == ["stop"]
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
