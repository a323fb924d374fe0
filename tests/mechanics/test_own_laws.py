"""Users' laws: against closed forms and ODEs, with every integrator; errors on one line."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import ufl
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_yeast import Scene, simulate
from fenics_yeast.mechanics import Law
from fenics_yeast.mechanics import hyperelasticity as wall
from fenics_yeast.mechanics.growth_laws import stress_driven
from fenics_yeast.scene import Numerics, StaticPath, Until

C, A = 3.0, 20.0  # MPa, 1
STRAIN, TIME = 0.005, 4.0  # 1, min


def fung(eps_e: Any, c: Any, a: Any) -> Any:
    """c/2 (exp(a (E1² + E2² + E1 E2)) - 1) of the Green-Lagrange strains."""
    E1, E2 = ((ufl.exp(2 * eps_e[i]) - 1) / 2 for i in range(2))
    return c / 2 * (ufl.exp(a * (E1**2 + E2**2 + E1 * E2)) - 1)


def by_strain(point: Any, threshold: Any, t_grw: Any) -> Any:
    """Each strain relaxes by its own excess over a threshold."""
    eps_e = point.eps - point.eps_g
    excess = [ufl.conditional(ufl.gt(e, threshold), e - threshold, 0) for e in (eps_e[0], eps_e[1])]
    return ufl.as_vector(excess) / t_grw


def slope(eps: float) -> float:
    """Derivative of the energy of equal strains by their logarithm: E = (exp 2ε - 1)/2."""
    E = (np.exp(2 * eps) - 1) / 2
    return C / 2 * np.exp(3 * A * E**2) * 6 * A * E * np.exp(2 * eps)


ENERGY = Law(fung, {"c": C, "a": A})
GROWTH = Law(by_strain, {"threshold": STRAIN, "t_grw": TIME})


@pytest.fixture(scope="module")
def membrane(cell_scene: Scene) -> Scene:
    """A membrane sphere: its pressure has a closed form for every energy."""
    return cell_scene.with_values(
        {
            "wall.bending": False,
            "growth.zone.half_angle": 180.0,
            "numerics": Numerics(elements=8, order=2, grading="uniform", geometry="curved"),
            "run.end": 10.0,
        }
    )


def test_a_fung_sphere_has_the_pressure_of_its_closed_form(membrane: Scene) -> None:
    """Virtual work: p = h ψ'(ε) / (R λ³), with λ = exp ε."""
    path = StaticPath(control="volume", until=Until(volume_ratio=2.0), steps=10)
    changes = {"growth": None, "run": None, "path": path, "numerics.elements": 40}
    result = simulate(membrane.with_values(changes), energy=ENERGY)
    assert result.status == "finished" and len(result.history) > 8
    eps = np.log(result.history.volume_ratio) / 3
    expected = 0.1 * slope(eps) / (2.5 * np.exp(3 * eps))
    assert expected[-1] > 50 * expected[1]  # it stiffens; a neo-Hookean sphere would soften
    np.testing.assert_allclose(result.history.pressure_MPa, expected, rtol=1e-5, atol=1e-9)


def ode_volume(pressure: float, end: float) -> float:
    """V/V0 of the whole sphere, whose growth is one ODE: p R λ³ = h ψ'(ε - ε^g)."""

    def strain(eps_g: float) -> float:
        return brentq(
            lambda eps: 0.1 * slope(eps - eps_g) - pressure * 2.5 * np.exp(3 * eps),
            eps_g, eps_g + 0.3, xtol=1e-14,
        )  # fmt: skip

    def rate(_: float, eps_g: np.ndarray) -> list[float]:
        return [max(strain(eps_g[0]) - eps_g[0] - STRAIN, 0.0) / TIME]

    grown = solve_ivp(rate, (0, end), [0.0], rtol=1e-11, atol=1e-13).y[0, -1] if end else 0.0
    return float(np.exp(3 * strain(grown)))


@pytest.mark.parametrize(
    ("numerics", "tolerance"),
    [
        ({"integrator": "sdirk3", "tolerance": 1e-6}, 2e-6),
        ({"integrator": "sdirk2", "step": 0.1}, 2e-6),
        ({"integrator": "backward-euler", "step": 0.01}, 2e-4),
        ({"integrator": "forward-euler", "step": 0.01}, 2e-4),
    ],
)
def test_a_whole_sphere_grows_as_its_ode(
    membrane: Scene, numerics: dict[str, object], tolerance: float
) -> None:
    scene = membrane.with_values({f"numerics.{key}": value for key, value in numerics.items()})
    result = simulate(scene, energy=ENERGY, growth_law=GROWTH)
    expected = ode_volume(0.20265, 10.0)
    assert expected > 1.3 > 1.2 > ode_volume(0.20265, 0.0)  # it has grown
    assert result.history.volume_ratio[-1] == pytest.approx(expected, rel=tolerance)


def test_implicit_steps_take_at_most_eight_iterations(membrane: Scene) -> None:
    """In long steps, as with the scene's own laws; a wrong tangent takes more."""
    step = {"numerics.integrator": "backward-euler", "numerics.step": 2.0}
    own = simulate(membrane.with_values(step), energy=ENERGY, growth_law=GROWTH)
    assert own.status == "finished" and own.rejected_steps == 0
    assert max(own.history.newton_iterations[1:]) <= 8


def test_a_law_may_be_a_plain_function(membrane: Scene) -> None:
    def neo_hookean(eps_e: Any) -> Any:
        return wall.ogden(eps_e, 40.0, 2.0)

    def published(point: Any) -> Any:
        return stress_driven(point, 1.0, 45.0)

    own = simulate(membrane, energy=neo_hookean, growth_law=published)
    scene = simulate(membrane)
    np.testing.assert_allclose(
        own.history.volume_ratio, scene.history.volume_ratio, rtol=1e-9, atol=0
    )


def nothing(*_: Any) -> None:
    return None


def number(*_: Any) -> float:
    return 1.0


def broken(*_: Any) -> Any:
    raise ZeroDivisionError("by zero")


@pytest.mark.parametrize(
    ("law", "error", "words"),
    [
        (nothing, TypeError, r"strain energy nothing returned nothing \(None\); expected a"),
        (number, TypeError, "strain energy number returned an object of type float; expected"),
        (lambda e: e, ValueError, r"returned the shape \(2,\); expected a scalar UFL expression"),
        (broken, ValueError, "strain energy broken raised ZeroDivisionError: by zero"),
        (Law(fung, {"c": 1.0}), ValueError, "strain energy fung raised TypeError: .*'a'"),
        (3.0, TypeError, "the strain energy is an object of type float; expected a"),
    ],
)
def test_an_invalid_energy_is_reported_on_one_line(
    membrane: Scene, law: Any, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words) as refused:
        simulate(membrane, energy=law)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("law", "error", "words"),
    [
        (nothing, TypeError, "growth law nothing returned nothing"),
        (lambda p: [p.tau[0], p.tau[1]], TypeError, r"type list; expected a UFL vector .*as_v"),
        (lambda p: p.tau[0], ValueError, r"returned the shape \(\); expected a UFL vector"),
        (lambda p: p.sigma, ValueError, "raised AttributeError: .*sigma"),
        (Law(nothing), TypeError, "growth law nothing returned nothing"),
    ],
)
def test_an_invalid_growth_law_is_reported_on_one_line(
    membrane: Scene, law: Callable[..., Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words) as refused:
        simulate(membrane, growth_law=law)
    assert "\n" not in str(refused.value)


def test_a_growth_law_needs_a_growing_zone(membrane: Scene) -> None:
    with pytest.raises(ValueError, match=r"needs a scene with a table \[growth\]"):
        simulate(membrane.with_values({"growth": None}), growth_law=GROWTH)
