"""Where the command `avobench` starts: with one thread and no closed stream, before any library that minds."""

import os
import sys

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"
for _name in ("stdin", "stdout", "stderr"):
    if getattr(sys, _name) is None:  # closed by who started this: no other file may get its number, here or in a worker
        setattr(sys, _name, open(os.devnull, "r" if _name == "stdin" else "w"))  # noqa: SIM115
        os.set_inheritable(getattr(sys, _name).fileno(), True)


def main() -> None:
    try:
        from avobench.cli import main as cli
    except KeyboardInterrupt:
        print("avobench: stopped before it began", file=sys.stderr)
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
