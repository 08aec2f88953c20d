"""The doorstep of the ``hqp`` command: it imports nothing, so that Ctrl-C is heard from the first import on."""

from __future__ import annotations

import sys


def main() -> None:
    """Run ``hqp`` and leave with its exit code."""
    try:
        from tasks.cli import main as command

        command()
    except KeyboardInterrupt:
        print("hqp: interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
