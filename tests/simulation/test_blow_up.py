"""Growth without bound: the time of blow-up against the ODE of a membrane, and its ending."""

import math

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from fenics_yeast import Scene, simulate

R, H, MU, P, THRESHOLD, TIME = 2.5, 0.1, 40.0, 0.20265, 1.0, 45.0


@pytest.fixture(scope="module")
def sphere(cell_scene: Scene) -> Scene:
    """A sphere that grows everywhere, its turgor applied at once."""
    changes = {
        "wall": {"thickness": H, "shear_modulus": MU, "ogden_exponent": 4.0},
        "turgor": {"pressure": P, "ramp": 0.0},
        "growth": {
            "zone": {"pole": "top", "half_angle": 180},
            "threshold": THRESHOLD,
            "time": TIME,
        },
        "run": {"end": 30.0},
        "numerics": {},
    }
    return cell_scene.with_values(changes)


def blow_up(alpha: float) -> float:
    """t* of the membrane, by its elastic strain e: p R exp(3 ε) = 2 h τ(e), ε^g = ε - e."""

    def strain(e: float) -> float:
        tau = 2 * MU / alpha * (math.exp(alpha * e) - math.exp(-2 * alpha * e))
        return math.log(2 * H * tau / (P * R)) / 3

    def slope(e: float) -> float:
        """Time per elastic strain: dε^g/de over the rate of (13)."""
        a, b = math.exp(alpha * e), math.exp(-2 * alpha * e)
        tau, d_tau = 2 * MU / alpha * (a - b), 2 * MU * (a + 2 * b)
        stress = math.sqrt(2) * tau * math.exp(-2 * strain(e))
        rate = (stress / THRESHOLD - 1) / (TIME * math.sqrt(2))
        return (d_tau / (3 * tau) - 1) / rate

    start = brentq(lambda e: strain(e) - e, 1e-4, 0.2, xtol=1e-15)
    return quad(slope, start, 60 / abs(alpha), limit=500)[0]


def test_the_ode_is_the_known_one() -> None:
    assert blow_up(4.0) == pytest.approx(13.0069, abs=1e-4)


@pytest.mark.parametrize("alpha", [4.0, 3.1, -1.51])
def test_growth_without_bound_has_the_time_of_the_ode(sphere: Scene, alpha: float) -> None:
    result = simulate(sphere.with_values({"wall.ogden_exponent": alpha}))
    assert result.status == "unbounded"
    assert "growth without bound" in result.message
    found = float(result.message.split("infinite at ")[1].split(" min")[0])
    assert found == pytest.approx(blow_up(alpha), abs=1e-3)
    assert result.end_time == pytest.approx(found, abs=1e-4) and result.rejected_steps < 30
    assert result.history.time_min[-1] < found


def test_a_softening_wall_loses_its_equilibrium_instead(sphere: Scene) -> None:
    assert simulate(sphere.with_values({"wall.ogden_exponent": 2.9})).status == "no-equilibrium"


def test_a_run_that_ends_before_is_finished(sphere: Scene) -> None:
    result = simulate(sphere.with_values({"run.end": 12.9}))
    assert result.status == "finished" and result.history.volume_ratio[-1] > 1e4


BUBBLE = """
[cell]
shape = "capsule"
diameter = 7.46
length = 14.92
[wall]
thickness = 0.347636
shear_modulus = 148.0
ogden_exponent = -2.0
bending = false
thickness_change = "elastic"
[turgor]
pressure = 13.931536
[growth]
threshold = 60.31518
time = 5.5
zone = { pole = "top", half_angle = 12.2 }
[run]
end = 15.455
[numerics]
tolerance = 0.01
"""


def test_a_bubble_that_is_followed_by_volume_is_named_early() -> None:
    """Followed to 2.5e7 volumes by 2830 steps, it becomes infinite at 3.24633 min."""
    result = simulate(Scene.from_toml(BUBBLE))
    assert result.status == "unbounded" and result.steps < 800
    assert result.end_time == pytest.approx(3.24633, abs=1e-3)
