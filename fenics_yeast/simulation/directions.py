"""What a parameter of a scene changes in the equations of its wall."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from ..geometry import Array
from ..mechanics import Coefficient, Law, OwnLaw, Shell, coefficients
from ..scene import Scene, SceneError, value_of
from ..solve import Direction
from .build import approximation_of, turgor, wall_of
from .discretise import is_turgid_outline

# Keys that change coefficients of the forms and the pressure, but neither nodes nor times.
_EXACT = re.compile(
    r"turgor\.pressure(\.value\.\d+)?"
    r"|wall\.(thickness|shear_modulus|ogden_exponent|young_modulus|poisson_ratio)"
    r"|wall\.(shear_moduli|ogden_exponents)\.\d+"
    r"|wall\.zone\.\d+\.(thickness|shear_modulus|modulus_factor)"
    r"|growth(\.\d+)?\.(threshold|time)"
    r"|load\.(point|ring)_force"
)
_CHANGE = 1e-5  # relative, of a parameter of which the coefficients are simple functions
_OTHERWISE = "use studies.simulate_with_derivatives, by differences"
_UNITS = ("rotation", "shear_force")  # of DOFs, on which nothing depends


def has_exact_sensitivity(scene: Scene, key: str) -> bool:
    """Whether a run of a scene can be differentiated by a key, with the discretisation held.

    It cannot by what moves nodes or times, such as sizes of the cell and of zones, and of a turgid
    outline also wall and turgor; nor if growth follows the tip, which the tangents do not know.
    """
    if _reshapes(scene, key):
        return False
    try:
        value = value_of(scene, key)
    except KeyError:
        return False
    return _EXACT.fullmatch(key) is not None and _held(scene) and isinstance(value, float)


def _reshapes(scene: Scene, key: str) -> bool:
    """Whether the unloaded shape depends on a parameter, as it does for a turgid outline."""
    return key.startswith(("wall.", "turgor.", "energy.")) and is_turgid_outline(scene)


def _held(scene: Scene) -> bool:
    """Whether tangents of a run are exact, and its steps are those of time."""
    follows = any(zone.polarity and zone.polarity.follow == "tip" for zone in scene.growing)
    return scene.path is None and not follows


@dataclass(frozen=True)
class Model:
    """A scene with laws of the user's own, if any, as values of coefficients and pressure."""

    scene: Scene
    energy: OwnLaw | None = None
    growth_law: OwnLaw | None = None

    def value(self, key: str) -> float:
        """Return the value of a parameter.

        Raises
        ------
        SceneError
            If the run cannot be differentiated by it.
        """
        kind, _, name = key.partition(".")
        if kind in ("energy", "growth_law") and not _reshapes(self.scene, key):
            law = getattr(self, kind)
            value = law.parameters.get(name) if isinstance(law, Law) else None
            if isinstance(value, float | int) and _held(self.scene):
                return float(value)
            if _held(self.scene):
                raise SceneError(f"sensitivities: {key}: the {kind} is no Law with this parameter")
        if has_exact_sensitivity(self.scene, key):
            return float(value_of(self.scene, key))
        raise SceneError(f"sensitivities: {_refusal(self.scene, key)}")

    def changed(self, key: str, value: float) -> Model:
        """Return the model with another value of a parameter."""
        kind, _, name = key.partition(".")
        if kind == "energy" and isinstance(self.energy, Law):
            return replace(self, energy=_changed(self.energy, name, value))
        if kind == "growth_law" and isinstance(self.growth_law, Law):
            return replace(self, growth_law=_changed(self.growth_law, name, value))
        table, _, number = key.rpartition(".")
        if number.isdecimal():  # the entry of a list, which a scene takes as one value
            values = [*value_of(self.scene, table)]
            values[int(number)] = value
            return replace(self, scene=self.scene.with_values({table: values}))
        return replace(self, scene=self.scene.with_values({key: value}))

    def coefficients(self, shell: Shell, numerics: Scene) -> dict[str, Coefficient]:
        """Return the coefficients on the nodes of a shell, with the numerics of a scene."""
        wall = wall_of(self.scene, shell.discretisation, self.energy, self.growth_law)
        return coefficients(wall, approximation_of(numerics), shell.rotation)


def _changed(law: Law, name: str, value: float) -> Law:
    return Law(law.function, {**law.parameters, name: value})


def direction(model: Model, shell: Shell, key: str) -> Direction:
    """Return what a parameter changes, with the discretisation of a shell held.

    Coefficients and pressure are differentiated by central differences: they are linear in nearly
    all parameters, and products of powers of the others.
    """
    value = model.value(key)
    change = _CHANGE * (abs(value) or 1.0)
    above, below = (model.changed(key, value + sign * change) for sign in (1, -1))
    high, low = (each.coefficients(shell, model.scene) for each in (above, below))
    found: dict[str, Coefficient] = {}
    for name in high:
        if name not in _UNITS and (slope := _slope(high[name], low[name], 2 * change)) is not None:
            found[name] = slope
    rises = turgor(above.scene), turgor(below.scene)
    forces = [side.scene.axial_load for side in (above, below)]
    more, less = (0.0 if load is None else load.force for load in forces)
    return Direction(
        found,
        lambda time: (rises[0](time) - rises[1](time)) / (2 * change),
        (more - less) / (2 * change),
    )


def _slope(high: Coefficient, low: Coefficient, change: float) -> Coefficient | None:
    """Return the difference quotient of a number or a function; None for equal numbers."""
    if not callable(high) and not callable(low):
        return None if high == low else (high - low) / change

    def at(S: Array) -> Array:
        above, below = (np.asarray(x(S) if callable(x) else x) for x in (high, low))
        return np.broadcast_to((above - below) / change, S.shape)

    return at


def _refusal(scene: Scene, key: str) -> str:
    """Return why a run of a scene cannot be differentiated by a key, and what to do."""
    try:
        value = None if key.startswith(("energy.", "growth_law.")) else value_of(scene, key)
    except KeyError:
        return f"{key}: the scene has no such key"
    if scene.path is not None:
        return f"{key}: a run along [path] has none; remove the table path"
    if not _held(scene):
        return f"{key} has no exact one where growth follows the tip; {_OTHERWISE}"
    if _reshapes(scene, key):
        return f"{key} has no exact one, as the unloaded shape depends on it; {_OTHERWISE}"
    if key == "turgor.pressure":
        return f"{key} is a table; choose one of its values, e.g. turgor.pressure.value.0"
    if isinstance(value, bool) or not isinstance(value, float | int):
        return f"{key}: expected the key of a number"
    return f"{key} has no exact one; {_OTHERWISE}"
