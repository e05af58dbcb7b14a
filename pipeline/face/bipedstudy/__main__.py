"""The command `bipedstudy`."""

from __future__ import annotations

from typing import NoReturn

import bipedstudy  # first: it says where the engine is  # noqa: F401


def main() -> NoReturn:
    """Run the command line."""
    from pipeline.cli import main as run

    run()


if __name__ == "__main__":
    main()
