"""Growth of walled cells under their own turgor, computed with FEniCSx.

>>> from fenics_yeast import Scene, simulate
>>> result = simulate(Scene.load("bud.toml"))
>>> result.history.volume_ratio
"""

import os
from typing import TYPE_CHECKING, Any

from .scene import MeasuredCurve, Scene, SceneError

if TYPE_CHECKING:
    from .simulation import Simulation, simulate
    from .studies import fit

# Before MPI loads UCX, which would keep SIGHUP for its own tracing (openucx/ucx, issue 10742).
os.environ.setdefault("UCX_DEBUG_SIGNO", "0")

__all__ = ["MeasuredCurve", "Scene", "SceneError", "Simulation", "fit", "simulate"]


def __getattr__(name: str) -> Any:
    if name == "__version__":  # reading it costs a tenth of the start-up
        from importlib.metadata import version

        return version("fenics-yeast")
    if name in ("Simulation", "simulate"):  # they load dolfinx, which a scene does not need
        from . import simulation

        return getattr(simulation, name)
    if name == "fit":
        from . import studies

        return studies.fit
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
