"""Where a clinic's files lie, and what a person may set of an installation."""

from rehab_app.config.folder import ClinicFolder, resolve_folder
from rehab_app.config.keys import KEYS, Key
from rehab_app.config.reading import FILE, FILE_VARIABLE, Loaded, load_settings, secret_key
from rehab_app.config.settings import (
    HealthSettings,
    LogSettings,
    MetricsSettings,
    RecomputeSettings,
    ServerSettings,
    Settings,
    StoreSettings,
)

__all__ = [
    "FILE",
    "FILE_VARIABLE",
    "KEYS",
    "ClinicFolder",
    "HealthSettings",
    "Key",
    "Loaded",
    "LogSettings",
    "MetricsSettings",
    "RecomputeSettings",
    "ServerSettings",
    "Settings",
    "StoreSettings",
    "load_settings",
    "resolve_folder",
    "secret_key",
]
