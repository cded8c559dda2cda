"""Modules of a user's own, by the path of their file: `path/to/file.py:Class` in every process that can read it.

Such a module is called `avobench.bench.plugins.user_files.PATH`, so that a worker that imports it finds the file.
"""

import os
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType
from urllib.parse import quote, unquote

__path__: list[str] = []
"""Makes this module a package, of which the user's are a part. None of them lies in a folder of it."""

PREFIX = f"{__name__}."


def module_name(path: str | Path) -> str:
    """The name of the module of a file."""
    return PREFIX + quote(os.path.abspath(path)).replace(".", "%2E")


def file_of(module: str) -> str | None:
    """The file of a module that `module_name` named; None of any other."""
    return unquote(module.removeprefix(PREFIX)) if module.startswith(PREFIX) else None


class _BesideTheFile(SourceFileLoader):
    """Runs a file with its folder on the path, so that it finds other files of the user's beside it."""

    def exec_module(self, module: ModuleType) -> None:
        folder = os.path.dirname(self.path)
        if folder not in sys.path:
            sys.path.append(folder)
        super().exec_module(module)


class _Finder(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        file = file_of(fullname)
        if file is None:
            return None
        return spec_from_file_location(fullname, file, loader=_BesideTheFile(fullname, file))


sys.meta_path.append(_Finder())
