"""The shared object of faults.c in this process, and the process started anew with it."""

import ctypes
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from robustness.warm import ENVIRONMENT

SOURCE = Path(__file__).with_name("faults.c")
KINDS = ("open", "write", "fsync", "close", "rename", "unlink", "mkdir", "rmdir", "chmod", "opendir")
"""The kinds in the order of the source, from 1."""
MANNERS = {"": 0, "torn": 1, "short": 2, "dies": 3}
GRANTED = -1
"""Every lock is granted, and none is held."""


def compiler() -> str | None:
    return shutil.which("gcc") or shutil.which("cc")


def compiled(folder: Path) -> Path:
    """The shared object, made in `folder`."""
    made = folder / "faults.so"
    subprocess.run([compiler(), "-shared", "-fPIC", "-O1", "-o", made, SOURCE, "-ldl"], check=True, timeout=60)
    return made


def proof(module: str, folder: Path, size: int) -> Any:
    """What `campaign(folder, size)` of a module finds, in a process that has the object loaded before all others."""
    library = compiled(folder)
    code = f"import json; from pathlib import Path; from robustness import {module}; "
    code += f"print(json.dumps({module}.campaign(Path({str(folder)!r}), {size})))"
    environment = {**os.environ, **ENVIRONMENT, "LD_PRELOAD": str(library), "FAULTS": str(library)}
    process = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert process.returncode == 0, process.stderr
    return json.loads(process.stdout.splitlines()[-1])


class Faults:
    """What fails in this process, which was started with the object."""

    def __init__(self) -> None:
        self._library = ctypes.CDLL(os.environ["FAULTS"])

    def set(self, **values: int) -> None:
        for name, value in values.items():
            ctypes.c_int.in_dll(self._library, f"faults_{name}").value = value

    def get(self, name: str) -> int:
        return ctypes.c_int.in_dll(self._library, f"faults_{name}").value

    def root(self, folder: Path) -> None:
        place = (ctypes.c_char * 4096).in_dll(self._library, "faults_root")
        place.value = str(folder).encode()
