"""Growth of walled cells under their own turgor, computed with FEniCSx.

>>> from fenics_yeast import Scene, simulate
>>> result = simulate(Scene.load("bud.toml"))
>>> result.history.volume_ratio
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .scene import Scene, SceneError

if TYPE_CHECKING:
    from .simulation import simulate

__all__ = ["Scene", "SceneError", "simulate"]


def __getattr__(name: str) -> Any:
    if name == "__version__":  # reading it costs a tenth of the start-up
        from importlib.metadata import version

        return version("fenics-yeast")
    if name == "simulate":  # loads dolfinx, which a scene alone does not need
        from .simulation import simulate

        return simulate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
