"""Fit simulators that have no likelihood, know how well that works, and find what a simulator lacks.

What there is stands in `__init__.pyi`, for readers, type checkers and `lazy_loader` alike. A name is imported when it
is first asked for, so that `import avobench` takes milliseconds.
"""

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
del lazy_loader


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version  # here, since it takes longer than all else of the import

        return version("avobench")
    return _load(name)
