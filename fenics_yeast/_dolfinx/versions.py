"""Import dolfinx, and detect by feature which version it is.

Known to run: dolfinx 0.5 (Debian 12), 0.9 (Debian 13) and 0.11 (PyPI).
"""

import contextlib
import sys
from collections.abc import Iterator
from importlib.metadata import version
from inspect import signature
from types import ModuleType, SimpleNamespace
from typing import Any


@contextlib.contextmanager
def _quick_pkg_resources() -> Iterator[None]:
    """Replace a library that UFL 2022 and FFCx 0.5 ask for their version; it takes long to load."""
    if "pkg_resources" in sys.modules:
        yield
        return
    module: Any = ModuleType("pkg_resources")
    module.get_distribution = lambda name: SimpleNamespace(version=version(name))
    sys.modules["pkg_resources"] = module
    try:
        yield
    finally:
        del sys.modules["pkg_resources"]


with contextlib.suppress(ImportError):  # the wheel from PyPI must load its libraries first
    import dolfinx_solver  # noqa: F401

try:
    with _quick_pkg_resources():
        import ffcx  # noqa: F401
        import ufl  # noqa: F401

    import basix
    import petsc4py

    from .._mpi import MPI

    petsc4py.init(["-no_signal_handler"])  # the command handles closed pipes and Ctrl-C
    import dolfinx.fem.petsc
    import dolfinx.mesh
    from dolfinx import fem as fem
    from dolfinx import jit, la
    from petsc4py import PETSc as PETSc
except ImportError as error:
    raise ImportError(
        f"dolfinx cannot be imported ({error}); on Debian run: sudo apt install python3-dolfinx; "
        "then use /usr/bin/python3, or a virtual environment of it with --system-site-packages; "
        "elsewhere, with Python 3.12 or later, run: pip install dolfinx-solver-real"
    ) from error

try:
    import basix.ufl as basix_ufl
except ImportError:  # dolfinx 0.5 describes elements in ufl
    basix_ufl = None

ADD = (la.InsertMode if hasattr(la, "InsertMode") else la.ScatterMode).add
NEW_SPACES = hasattr(fem, "functionspace")
NEW_JIT = "jit_options" in signature(fem.form).parameters
EVAL_ON_MESH = "mesh" in signature(fem.Expression.eval).parameters
JIT_KEYWORD = "jit_options" if NEW_JIT else "jit_params"
# fem.form adds these options, which are part of a form's name in the cache.
SCALAR = {"scalar_type": dolfinx.default_scalar_type} if NEW_JIT else {}

__all__ = [
    "ADD",
    "EVAL_ON_MESH",
    "JIT_KEYWORD",
    "MPI",
    "NEW_JIT",
    "NEW_SPACES",
    "SCALAR",
    "PETSc",
    "basix",
    "basix_ufl",
    "dolfinx",
    "fem",
    "jit",
    "la",
]  # fmt: skip
