"""``python -m benchmarks``: Ctrl-C is heard from the first import on."""

import sys

try:
    from .command import main

    main()
except KeyboardInterrupt:
    print("benchmarks: interrupted", file=sys.stderr)
    sys.exit(130)
