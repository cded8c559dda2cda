"""Find where simulation and measurement disagree, name the missing effect, add it, and show the gap shrink.

What there is stands in `__init__.pyi`; a name is loaded when it is first asked for, since SciPy's statistics take a
second.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
del lazy_loader
