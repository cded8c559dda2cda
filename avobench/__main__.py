"""Where the command `avobench` starts: one thread a process, set before any library that reads it is loaded."""

import os
import sys

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"


def main() -> None:
    try:
        from avobench.cli import main as cli
    except KeyboardInterrupt:
        print("avobench: stopped before it began", file=sys.stderr)
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
