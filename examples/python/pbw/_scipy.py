"""Classes of ours that SciPy takes for its own.

SciPy's interpolators accept instances of scipy.spatial.Delaunay only; isinstance looks at type(x), then at
x.__class__.  What they read next are documented attributes.  So the __class__ of an object of ours is a subclass of
both classes once scipy.spatial is loaded; this package never loads it.
"""
import functools
import sys


@functools.lru_cache(maxsize=None)
def _both(cls, other):
    return type(cls.__name__, (cls, other), {"__module__": cls.__module__, "__doc__": cls.__doc__, "_own": cls})


def as_scipy(cls, name):
    """A subclass of cls and of scipy.spatial's class of that name; cls where SciPy is not loaded or has none."""
    other = getattr(sys.modules.get("scipy.spatial"), name, None)
    return cls if other is None or issubclass(cls, other) else _both(cls, other)


def own(cls):
    """The class that as_scipy was given."""
    return cls.__dict__.get("_own", cls)
