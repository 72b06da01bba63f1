"""``rehab-app`` and ``python -m rehab_app``."""

from __future__ import annotations

import os


def main() -> None:
    """Run the command line."""
    # Before numpy is loaded, here and in the motion process: threads of the linear algebra only get in each
    # other's way on matrices as small as a hand's, and would stall a live recording for seconds.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from rehab_app.cli.app import app

    app()


if __name__ == "__main__":
    main()
