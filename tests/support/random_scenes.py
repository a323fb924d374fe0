"""Random scenes for property-based tests: physical ones, and texts that may be anything."""

from typing import Any

import tomli_w
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

from . import scenes

SHAPES = ("sphere", "spheroid", "capsule")
OPEN_SHAPES = ("cap", "disc", "cone", "cylinder")
EXPONENTS = (-4.0, -2.0, -1.5, -1.0, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)


def between(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of three digits, so that a failing scene can be read."""
    return st.floats(low, high).map(lambda x: float(f"{x:.3g}"))


@st.composite
def physical_scenes(draw: DrawFn) -> dict[str, Any]:
    """Tables of a walled cell that could exist: thin, strained by less than it breaks, growing."""
    diameter, shape = draw(between(1.0, 20.0)), draw(st.sampled_from(SHAPES))
    cell: dict[str, Any] = {"shape": shape, "diameter": diameter}
    if shape == "spheroid":
        cell["height"] = diameter * draw(between(0.5, 3.0))
    if shape == "capsule":
        cell["length"] = diameter * draw(between(1.2, 5.0))
    modulus = draw(between(5.0, 200.0))
    wall: dict[str, Any] = {"thickness": diameter * draw(between(0.005, 0.06))}
    if draw(st.booleans()):
        wall |= {"shear_modulus": modulus, "ogden_exponent": draw(st.sampled_from(EXPONENTS))}
    else:
        wall |= {"law": "linear", "young_modulus": 3 * modulus, "poisson_ratio": 0.4}
    wall["bending"] = draw(st.booleans())
    wall["energy_per"] = draw(st.sampled_from(("reference", "grown")))
    wall["thickness_change"] = draw(st.sampled_from(("none", "elastic")))
    stress = modulus * draw(between(0.01, 0.6))
    pressure = 4 * wall["thickness"] * stress / diameter
    time = draw(between(5.0, 90.0))
    zones: list[dict[str, Any]] = [
        {"pole": "top", "half_angle": draw(between(8.0, 60.0))},
        {"from_fraction": 0.0, "to_fraction": 1.0},
        {"pole": "both", "half_angle": draw(between(8.0, 40.0))},
    ]
    growth = {
        "zone": draw(st.sampled_from(zones)),
        "threshold": stress * draw(between(0.4, 1.5)),
        "time": time,
    }
    if draw(st.booleans()):
        growth["polarity"] = {"width": diameter * draw(between(0.05, 0.5))}
    return {
        "cell": cell,
        "wall": wall,
        "turgor": {"pressure": pressure},
        "growth": growth,
        "run": {"end": time * draw(between(0.5, 3.0))},
        "numerics": {"tolerance": 0.01},
    }


def _pressing(draw: DrawFn, radius: float) -> dict[str, Any]:
    """Tables of an unloaded cell or a part of one, its wall, and a modest axial force on it."""
    shape = draw(st.sampled_from((*SHAPES, *OPEN_SHAPES)))
    cell: dict[str, Any] = {"shape": shape, "diameter": 2 * radius}
    match shape:
        case "spheroid":
            cell["height"] = 2 * radius * draw(between(0.5, 3.0))
        case "capsule":
            cell["length"] = 2 * radius * draw(between(1.2, 5.0))
        case "cap":
            cell = {"shape": shape, "radius": radius, "half_angle": draw(between(10.0, 120.0))}
        case "cone":
            inner = draw(st.sampled_from((0.5, 1.0, 1.5)))
            cell = {"shape": shape, "outer_diameter": 2 * radius, "inner_diameter": inner * radius}
            cell["height"] = radius * draw(between(0.1, 2.0))
        case "cylinder":
            cell["length"] = radius * draw(between(0.5, 6.0))
    if shape in OPEN_SHAPES:
        cell["edge"] = draw(st.sampled_from(("clamped", "hinged")))
    modulus = draw(between(5.0, 200.0))
    wall: dict[str, Any] = {"thickness": radius * draw(between(0.01, 0.08))}
    if draw(st.booleans()):
        wall |= {"shear_modulus": modulus, "ogden_exponent": draw(st.sampled_from(EXPONENTS))}
    else:
        wall |= {"law": "linear", "young_modulus": 3 * modulus, "poisson_ratio": 0.4}
    return {"cell": cell, "wall": wall, "numerics": {"tolerance": 0.01}}


@st.composite
def loaded_scenes(draw: DrawFn) -> dict[str, Any]:
    """Tables of elastic walls, closed and open, whose turgor varies in time or along a path."""
    radius = draw(between(0.5, 10.0))
    tables = _pressing(draw, radius)
    wall = tables["wall"]
    modulus = wall.get("shear_modulus", wall.get("young_modulus", 0.0) / 3)
    membrane = 2 * wall["thickness"] / radius * modulus  # pressure that strains by about one
    pressures = st.one_of(between(0.01, 0.5), between(-0.05, -0.001))
    match draw(st.sampled_from(("table", "external", "path"))):
        case "table":
            values = [membrane * draw(pressures) for _ in range(3)]
            tables["turgor"] = {"pressure": {"time": [0.0, 4.0, 8.0], "value": values}}
            tables["run"] = {"end": 10.0}
        case "external":
            tables["turgor"] = {"pressure": membrane * draw(between(-0.05, -0.001))}
        case _:
            control = draw(st.sampled_from(("pressure", "volume", "arc-length")))
            tables["path"] = {"control": control, "steps": draw(st.integers(5, 60))}
            tables["path"]["stop_at_contact"] = True  # beyond, a wall goes through itself
            if tables["cell"]["shape"] != "disc" and draw(st.booleans()):
                tables["path"]["until"] = {"volume_ratio": draw(between(0.6, 3.0))}
            else:
                tables["path"]["until"] = {"pressure": membrane * draw(pressures)}
    return tables


LETTERS = "[]{}\"=.,0123456789-+eE\n abcdefghijklmnopqrstuvwxyzµ°'#_\\\x00"


@st.composite
def damaged_texts(draw: DrawFn) -> str:
    """A scene with lines removed, repeated and exchanged, values replaced and letters inserted."""
    text = draw(st.sampled_from([scenes.BUD, scenes.BALLOON, scenes.SMALL]))
    lines = text.splitlines()
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(lines) - 1))
        match draw(st.integers(0, 4)):
            case 0:
                del lines[place]
            case 1:
                lines.insert(place, draw(st.sampled_from(lines)))
            case 2:
                key = lines[place].split("=")[0]
                lines[place] = f"{key}= {draw(toml_values())}"
            case 3:
                at = draw(st.integers(0, len(lines[place])))
                more = draw(st.text(LETTERS, min_size=1, max_size=3))
                lines[place] = lines[place][:at] + more + lines[place][at:]
            case _:
                other = draw(st.integers(0, len(lines) - 1))
                lines[place], lines[other] = lines[other], lines[place]
        lines = lines or [""]
    return "\n".join(lines)


def toml_values() -> st.SearchStrategy[str]:
    """Values of any kind as TOML."""
    numbers = st.one_of(
        st.floats(),
        st.integers(-(2**63), 2**63 - 1),
        st.sampled_from([0, -1, 1e308, 1e-308, 5e-324]),
    )
    words = st.one_of(
        st.text(LETTERS, max_size=8),
        st.sampled_from(["5 um", "1e400 MPa", "-3 min", "2 atm", "90 deg", "nan um", "top"]),
    )
    values = st.recursive(
        st.one_of(numbers, words, st.booleans()),
        lambda inner: st.one_of(
            st.lists(inner, max_size=3), st.dictionaries(st.text("abz", max_size=3), inner)
        ),
        max_leaves=4,
    )
    return values.map(lambda value: tomli_w.dumps({"v": [value]}).strip().partition("=")[2])
