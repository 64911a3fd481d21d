"""python_scipy.py: runs tests of the SciPy that is installed with pbw.Delaunay in place of its Delaunay: all tests of
its Qhull and interpolation modules that make such an object.  See scipy_tests_of_its_own in python.py.
"""
import contextlib
import inspect
import io
import re
import types

import pbw

MODULES = "scipy.spatial.tests.test_qhull", "scipy.interpolate.tests.test_interpnd"

# Tests that fail, and must fail in this way: pattern of the name, pattern of the failure, reason.
FLAT = r"points must have the shape \(npoints, 2\) or \(npoints, 3\), not \(\d+, [4-9]\)"
DIFFERENT = (
    (r"test_find_simplex|test_2d_square|TestUtilities::test_convex_hull", "Arrays are not equal",
     "compares with numbers of simplices and with the diagonal of a square that Qhull happens to choose"),
    (r"test_nd_simplex|test_more_barycentric_transforms", FLAT,
     "goes through dimensions from 2 on, and ends at 4, which pbw has not"),
    (r"\[random-[4-9]d", FLAT, "has more than 3 dimensions"),
    (r"test_degenerate_barycentric_transforms", "AssertionError: 31",
     "allows 22 triangles without coordinates, the number that Qhull leaves; the exact answer has 31"),
    (r"test_joggle", "Arrays are not equal", "QJ moves duplicates apart; pbw moves no point"),
    (r"test_furthest_site", "furthest_site is not supported", "pbw has no furthest-site triangulation"),
    (r"test_vertices_deprecation", "no attribute 'vertices'", "a name that SciPy 1.11 removed"),
)


def _uses_delaunay(item):
    return "qhull.Delaunay(" in inspect.getsource(item.function)


class _Plugin:
    def __init__(self):
        self.failures = {}         # text by name, None for a test that passed

    def pytest_collection_modifyitems(self, items):
        items[:] = filter(_uses_delaunay, items)
        for module in {item.module for item in items}:
            stand_in = types.ModuleType("qhull")
            stand_in.__dict__.update(vars(module.qhull), Delaunay=pbw.Delaunay)
            module.qhull = stand_in

    def pytest_runtest_logreport(self, report):
        if report.when == "call" or report.failed:
            self.failures[report.nodeid.partition("::")[2]] = report.longreprtext if report.failed else None


def run():
    """How many tests passed, how many failed as the list says, and faults in words; ImportError without pytest."""
    import pytest
    plugin, printed = _Plugin(), io.StringIO()
    with contextlib.redirect_stdout(printed):
        pytest.main(["-q", "-p", "no:cacheprovider", "-c", "/dev/null", "--pyargs", *MODULES], plugins=[plugin])
    faults, passed, listed = [], 0, 0
    for name, text in plugin.failures.items():
        expected = [failure for pattern, failure, _ in DIFFERENT if re.search(pattern, name)]
        if text is None and not expected:
            passed += 1
        elif text is not None and expected and re.search(expected[0], text):
            listed += 1
        else:
            faults.append("%s: %s" % (name, "passes, though it is listed" if text is None else text[-300:]))
    return passed, listed, faults, printed.getvalue()
