"""Compile forms and expressions, once for all processes and ranks."""

import contextlib
import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction
from ufl.variable import Label

from .. import _form_cache
from . import together
from .versions import EVAL_ON_MESH, JIT_KEYWORD, MPI, SCALAR, fem, jit

_JIT = {"cffi_extra_compile_args": ["-O1", "-fno-math-errno"], "cffi_libraries": ["m"]}
_COMPILERS = ("cffi", "distutils", "setuptools")  # their errors concern the compiler, not the form

T = TypeVar("T")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Suppress the compiler's own lines; it sets the root logger to show them."""
    root = logging.getLogger()
    level, disabled = root.level, root.manager.disable
    logging.disable(max(disabled, logging.INFO))
    try:
        yield
    finally:
        root.setLevel(level)
        logging.disable(disabled)


def compiled(comm: Any, source: Any, make: Callable[..., T]) -> T:
    """Compile a source by `make`, on all ranks of a communicator."""
    place = comm.bcast(_place(source) if comm.rank == 0 else None)
    options = {JIT_KEYWORD: _options(place)}
    try:
        with _quiet():
            if comm.size == 1:
                with _form_cache.held(place), together.watched(place):
                    return make(**options)
            # Only rank 0 compiles: the lock's owner must not wait for ranks that need the lock.
            # An error there occurs again in `make`, on all ranks.
            if comm.rank == 0:
                with contextlib.suppress(Exception), _form_cache.held(place):
                    jit.ffcx_jit(MPI.COMM_SELF, source, SCALAR, options[JIT_KEYWORD])
            return make(**options)
    except Exception as error:
        library = type(error).__module__.partition(".")[0]
        if library in _COMPILERS or "just-in-time compilation" in str(error):
            raise _form_cache.compiler_error(place, error) from error
        raise


def _place(source: Any) -> Path:
    """Return the directory for a form, an expression with its points, or an element.

    The signature of a form serves FFCx again; that of an expression would be computed once more.
    """
    if isinstance(source, ufl.Form):
        identity = source.signature()
    elif isinstance(source, tuple):
        expression, points = source
        identity = f"{expression.ufl_shape} at {len(points)} points"
    else:
        identity = repr(source)
    return _form_cache.place_of(identity)


def _options(place: Path) -> dict[str, Any]:
    return {**_JIT, "cache_dir": place}


def compile_form(form: Any) -> Any:
    """Compile a form."""
    if plan := together.plan():
        return plan.add(form)
    comm = form.ufl_domain().ufl_cargo().comm
    return compiled(comm, form, lambda **jit: fem.form(form, **jit))


class _NumberedLabels(MultiFunction):
    """Number the labels of variables in order of appearance.

    Newer releases of UFL count them over the process and include the count in signatures, so
    that no expression would be found in the cache.
    """

    def __init__(self) -> None:
        super().__init__()
        self._numbered: dict[Any, Any] = {}

    expr = MultiFunction.reuse_if_untouched

    def terminal(self, o: Any) -> Any:
        return o

    def label(self, o: Any) -> Any:
        return self._numbered.setdefault(o, Label(len(self._numbered)))


def compile_expression(expression: Any, points: NDArray[np.float64]) -> Any:
    """Compile an expression at points of the reference interval."""
    if EVAL_ON_MESH:  # dolfinx 0.5 has a UFL that numbers labels itself
        expression = map_expr_dag(_NumberedLabels(), expression)
    if plan := together.plan():
        return plan.add((expression, points))
    comm = expression.ufl_domain().ufl_cargo().comm
    make = fem.Expression
    return compiled(comm, (expression, points), lambda **jit: make(expression, points, **jit))


def compiled_together(comm: Any, make: Callable[[], T]) -> T:
    """Return what a function makes that compiles forms; it may be called three times.

    Where forms are missing in the cache, they are compiled by as many processes as cores.
    """

    def compile_one(source: Any) -> None:
        place = _place(source)
        with _quiet(), _form_cache.held(place):
            jit.ffcx_jit.__wrapped__(source, SCALAR, _options(place))  # without MPI

    return together.together(make, compile_one, comm)
