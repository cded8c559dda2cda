"""Coverage-guided fuzzing of the readers of events and tables, with atheris: `python -m fuzz.guided npy -runs=10000`.

atheris watches which branches an input reaches and changes the inputs that reach new ones. It is installed only where
this is asked for (`pip install atheris`); the first argument is a format, the others are libFuzzer's.
"""

import sys
import tempfile
from pathlib import Path


def main() -> None:
    import atheris

    with atheris.instrument_imports(include=["avobench.bench", "numpy.lib", "zipfile", "uproot"]):
        from fuzz.inputs import sound_events
        from fuzz.targets import Events, Packed
    kind, *options = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as corpus:
        target = Packed(Path(folder)) if kind == "packed" else Events(Path(folder), kind)
        sound = target.content if isinstance(target, Packed) else sound_events(kind)
        (Path(corpus) / "sound").write_bytes(sound)
        atheris.Setup([sys.argv[0], *options, corpus], target.check)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
