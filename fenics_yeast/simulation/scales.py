"""Characteristic pressure, length and force of a scene, and the residual tolerance."""

from ..scene import PressureTable, Scene

_ROUND_OFF = 1e-12  # of the nodal forces, for those that would double the wall's length
_LEAST = 2e-9  # relative residual; smaller ones are lost in round-off where growth is large
# Relative residual: a part of the tolerance, but not so large that steps of growth would fail.
_PART, _MOST = 0.2, 5e-5
# Relative residual of a run that repeats the long steps of another one: where growth begins within
# the wall in such a step, growth strains are solved to no more than this.
_REPEATED = 1e-7


def pressure_scale(scene: Scene) -> float:
    """Return `μ h / R` in MPa: the pressure that strains a cell of this size by about one."""
    return scene.wall.shear_modulus * scene.wall.thickness / scene.cell.radius


def length_scale(scene: Scene) -> float:
    """Return `√(R h)` in µm: the width of a boundary layer, and of a dent under a force."""
    return float((scene.cell.radius * scene.wall.thickness) ** 0.5)


def force_scale(scene: Scene) -> float:
    """Return `8 μ h²/R √(R h)` in µN: about the force that dents a sphere by `√(R h)`.

    The stiffness is that of a point force on a spherical shell (Reissner 1946).
    """
    stiffness = 8 * scene.wall.shear_modulus * scene.wall.thickness**2 / scene.cell.radius
    return stiffness * length_scale(scene)


def residual_tolerance(scene: Scene, nodes: int, given: bool = False) -> float:
    """Return the norm of the residual in µN that counts as zero, on a number of nodes.

    `given` says that the run repeats given steps.
    """
    precision = _precision(scene)
    if given and scene.growth is not None:
        precision = min(_REPEATED, precision)
    return precision * _load(scene, nodes, precision)


def _precision(scene: Scene) -> float:
    """Return the relative residual that counts as zero, below the errors of adaptive steps."""
    numerics = scene.numerics
    fixed = numerics.step is not None or scene.growth is None
    return 1e-8 if fixed else max(_LEAST, min(_MOST, _PART * numerics.tolerance))


def _load(scene: Scene, nodes: int, precision: float) -> float:
    """Return the size of the nodal forces in µN, but no smaller than round-off allows.

    Small loads may bend an open wall, and a force is small beside turgor.
    """
    sizes = _pressures(scene)
    if scene.axial_load is not None or not scene.cell.closed:
        sizes = _pressures_of_open_wall(scene) + _pressures_of_force(scene)
    least = _ROUND_OFF / precision * pressure_scale(scene)
    return float(max(*sizes, least) * scene.cell.radius**2 / nodes**0.5)


def _pressures(scene: Scene) -> list[float]:
    """Return the sizes of the pressures of a scene in MPa."""
    pressure = scene.turgor.pressure
    if scene.path is not None and not scene.path.until.of_load:
        pressure = scene.path.until.pressure or pressure_scale(scene)
    values = pressure.value if isinstance(pressure, PressureTable) else (pressure,)
    return [abs(value) for value in values]


def _pressures_of_open_wall(scene: Scene) -> list[float]:
    """Return the same; on a path to a volume, what bends the wall or strains a membrane."""
    if scene.path is None or scene.path.until.volume_ratio is None:
        return _pressures(scene)
    unit = pressure_scale(scene)
    slender = scene.wall.thickness / scene.cell.radius
    return [slender**2 * unit if scene.wall.bending else unit]


def _pressures_of_force(scene: Scene) -> list[float]:
    """Return the sizes of the forces of a scene as pressures on `R²` in MPa."""
    load, path, radius = scene.axial_load, scene.path, scene.cell.radius
    sizes = [] if load is None else [abs(load.force) / radius**2]
    if path is not None and path.until.of_load:
        slender = scene.wall.thickness / radius
        moved = path.until.displacement or 0.0
        force = path.until.force or pressure_scale(scene) * slender * radius * moved
        sizes.append(abs(force) / radius**2)
    return sizes
