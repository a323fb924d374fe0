"""Surfaces of revolution for ParaView: a file per saved time, and a series."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..geometry import Array, Intervals
from ..output import SERIES, SURFACES, replace_file
from ..scene import Scene
from ..simulation import Profile, Profiles
from . import wall_fields

_AROUND = 64  # edges of a ring: its area is 0.16 % less than that of the circle
_RINGS = 160  # from end to end
_FINER = 8  # possible rings between two nodes
_CLOSED = 1e-9  # radius over the largest one, at which an end is a pole


def write_surfaces(directory: Path, scene: Scene, profiles: Profiles) -> Path:
    """Write the wall at the saved times to an output directory; return the series to open."""
    (directory / SURFACES).mkdir(parents=True, exist_ok=True)
    names = [f"{SURFACES}/{number:04d}.vtu" for number in range(len(profiles))]
    for name, profile in zip(names, profiles, strict=True):
        _write(directory / name, profile, profiles.zones, scene)
    lines = [
        f'    <DataSet timestep="{profile.time!r}" file="{name}"/>'
        for profile, name in zip(profiles, names, strict=True)
    ]
    kind = 'type="Collection" version="0.1" byte_order="LittleEndian"'
    head = f'<?xml version="1.0"?>\n<VTKFile {kind}>\n  <Collection>'
    text = "\n".join([head, *lines, "  </Collection>\n</VTKFile>\n"])
    replace_file(directory / SERIES, text.encode())
    return directory / SERIES


def _write(path: Path, profile: Profile, zones: Sequence[Intervals], scene: Scene) -> None:
    import meshio

    S, r, z = _meridian(profile, zones)
    points, rings = _points(r, z)
    triangles = [_band(lower, upper) for lower, upper in pairwise(rings)]
    ring_of = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    numbers = wall_fields.zone_numbers(zones, (S[1:] + S[:-1]) / 2)
    stress = wall_fields.mean(profile, profile.stress)
    fields = {
        "growth strain": wall_fields.area_strain(profile),
        "Cauchy stress, meridional (MPa)": stress[:, 0],
        "Cauchy stress, hoop (MPa)": stress[:, 1],
    }
    if thresholds := [growth.threshold for growth in scene.growing]:
        fields["stress / threshold"] = wall_fields.stress_ratio(profile, zones, thresholds)
    surface = meshio.Mesh(
        points.astype(np.float32),
        [("triangle", np.concatenate(triangles))],
        point_data={
            name: np.interp(S, profile.S_points, values)[ring_of].astype(np.float32)
            for name, values in fields.items()
        },
        cell_data={"zone": [np.repeat(numbers, [len(band) for band in triangles])]},
    )
    temporary = path.with_name(path.name + ".part")
    surface.write(temporary, file_format="vtu")
    temporary.replace(path)


def _meridian(profile: Profile, zones: Sequence[Intervals]) -> tuple[Array, Array, Array]:
    """Return `S, r, z` of rings, evenly spaced along the deformed meridian and at zone edges."""
    S, r, z = wall_fields.outline(profile, _FINER)
    numbers = wall_fields.zone_numbers(zones, (S[1:] + S[:-1]) / 2)
    length = np.append(0.0, np.cumsum(np.hypot(np.diff(r), np.diff(z))))
    even = np.searchsorted(length, np.linspace(0, length[-1], _RINGS + 1) * (1 - 1e-12))
    chosen = np.union1d(even, np.flatnonzero(np.diff(numbers)) + 1)
    return S[chosen], r[chosen], z[chosen]


def _points(r: Array, z: Array) -> tuple[Array, list[NDArray[np.int32]]]:
    """Return the points of all rings, and the indices of each ring; a pole has one point."""
    angles = 2 * np.pi * np.arange(_AROUND) / _AROUND
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    points: list[Array] = []
    rings = []
    first = 0
    for radius, height in zip(r, z, strict=True):
        pole = abs(radius) <= _CLOSED * r.max()
        flat = np.zeros((1, 2)) if pole else radius * around
        points.append(np.column_stack([flat, np.full(len(flat), height)]))
        rings.append(np.arange(first, first + len(flat), dtype=np.int32))
        first += len(flat)
    return np.concatenate(points), rings


def _band(lower: NDArray[np.int32], upper: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the triangles between two rings, with normals pointing outward."""
    a, b, c, d = (np.broadcast_to(ring, _AROUND)
                  for ring in (lower, np.roll(lower, -1), upper, np.roll(upper, -1)))  # fmt: skip
    below, above = np.column_stack([a, b, d]), np.column_stack([a, d, c])
    return np.concatenate(([below] if len(lower) > 1 else []) + ([above] if len(upper) > 1 else []))
