"""Fit simulators that have no likelihood, know how well that works, and find what a simulator lacks.

What there is stands in `__init__.pyi`, for readers, type checkers and `lazy_loader` alike. A name is imported when it
is first asked for, so that `import avobench` takes milliseconds.
"""

from importlib.metadata import version

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__version__ = version("avobench")
del lazy_loader, version
