"""The OpenNI 2 library: found, loaded once, and asked which cameras there are."""

from __future__ import annotations

import os
import sysconfig
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

from rehab_app.cameras.lost import missing_extra, missing_library

_LIBRARY = "libOpenNI2.so"
_PACKAGES = "libopenni2-0 libopenni2-dev"
_LOADING = threading.Lock()


def driver() -> Any:
    """The module ``openni.openni2``, with its library loaded.

    Raises:
        Refused: The extra or the library is not installed.
    """
    try:
        openni2: Any = import_module("openni.openni2")
    except ImportError:
        raise missing_extra("OpenNI camera", "openni") from None
    with _LOADING:
        if not openni2.is_initialized():
            _load(openni2)
    return openni2


def _load(openni2: Any) -> None:
    """Load the library from where it lies, once.

    Its own search would change the working folder of the whole process meanwhile; a library that it
    believes to have found already is taken as it is.
    """
    folder = library_folder()
    if folder is None:
        raise missing_library("OpenNI camera", _LIBRARY, _PACKAGES)
    try:
        if not openni2.loaded_dll_directory:
            openni2.c_api.load_dll(str(folder / _LIBRARY))
            openni2.loaded_dll_directory = str(folder)
        openni2.initialize()
    except (OSError, openni2.OpenNIError) as error:
        raise missing_library("OpenNI camera", _LIBRARY, _PACKAGES) from error


def uris() -> tuple[str, ...]:
    """Addresses of the cameras that are connected.

    Raises:
        Refused: The extra or the library is not installed.
    """
    return tuple(uri.decode(errors="replace") for uri in driver().Device.enumerate_uris())


def library_folder() -> Path | None:
    """The folder of the library: that of its own variables, else where Debian and others put it."""
    multiarch = str(sysconfig.get_config_var("MULTIARCH") or "x86_64-linux-gnu")
    stated = (os.environ.get(name, "") for name in ("OPENNI2_REDIST64", "OPENNI2_REDIST"))
    usual = (f"/usr/lib/{multiarch}", "/usr/lib", "/usr/lib64", "/usr/local/lib")
    folders = [Path(name) for name in (*stated, *usual) if name]
    return next((folder for folder in folders if (folder / _LIBRARY).is_file()), None)
