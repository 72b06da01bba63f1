"""The calendar of the clinic: which day it is where the patient is, and when that day ends."""

from __future__ import annotations

from datetime import date, datetime, timedelta


def local_day(utc_ns: int) -> date:
    """The date of an instant in this machine's time zone."""
    return datetime.fromtimestamp(utc_ns // 1_000_000_000).astimezone().date()


def day_start_ns(utc_ns: int) -> int:
    """When the day of an instant began, UTC in ns."""
    return _midnight_ns(local_day(utc_ns))


def day_end_ns(utc_ns: int) -> int:
    """When the day of an instant ends, UTC in ns."""
    return _midnight_ns(local_day(utc_ns) + timedelta(days=1))


def _midnight_ns(day: date) -> int:
    return int(datetime(day.year, day.month, day.day).astimezone().timestamp()) * 1_000_000_000
