"""Growth in time: a sphere against its ODE, orders of the methods, failed steps."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import get_args

import numpy as np
import pytest

from fenics_yeast import simulate
from fenics_yeast.scene import Integrator, Run
from fenics_yeast.simulation import build_shell
from fenics_yeast.solve.equilibrium import Equilibrium, EquilibriumError
from fenics_yeast.solve.runge_kutta import TABLEAUX
from fenics_yeast.solve.time_stepper import TimeStepper

TOLERANCE = 1e-11  # µN


# --- a sphere that grows everywhere -------------------------------------------------------


def run_sphere(scene, table, ratio: float):
    """The sphere of the ODE with another h/R0; p R0/h, its only trace in the ODE, is kept."""
    times = tuple(float(row["time_min"]) for row in table)
    values = {
        "wall.thickness": 2.5 * ratio,
        "turgor.pressure": 0.20265 * ratio / 0.04,
        "numerics.integrator": "sdirk3",
        "numerics.step": 0.1,
        "run": Run(end=times[-1], save=times),
    }
    result = simulate(scene.with_values(values))
    assert result.status == "finished"
    rows = [result.history.at(time) for time in times]
    volumes = np.array([row.volume_ratio for row in rows])
    growth = np.array([row.max_growth_strain for row in rows])
    expected = np.array([float(row["volume_ratio"]) for row in table])
    strains = np.array([float(row["growth_strain"]) for row in table])
    return volumes / expected - 1, growth - strains


@pytest.fixture(scope="module")
def sphere_errors(sphere_scene, read_table):
    table = read_table("sphere_ode.csv")
    return {ratio: run_sphere(sphere_scene, table, ratio) for ratio in (0.04, 0.02)}


def test_growing_sphere_follows_the_ode(sphere_errors):
    """The difference is the wall's bending: the outer fibres grow a little more."""
    volumes, growth = sphere_errors[0.04]
    assert np.all(np.abs(volumes[:-2]) < 1e-4)  # to 8 min, V/V0 = 4.3
    assert np.all(np.abs(volumes) < 4e-4)  # to 11 min, V/V0 = 15
    assert np.all(np.abs(growth) < 4e-3)


def test_error_against_the_ode_falls_with_the_square_of_the_thickness(sphere_errors):
    thick, thin = sphere_errors[0.04][0], sphere_errors[0.02][0]
    np.testing.assert_allclose(thick / thin, 4, rtol=0.05)


# --- integrators --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", get_args(Integrator))
def test_integrator_has_its_order(sphere_scene, name):
    """Fitted to the differences of V/V0 at 2 min between steps and half of them."""
    order = TABLEAUX[name].order
    first = 0.25 if name == "forward-euler" else 1.0  # within its limit of stability
    steps = first * 0.5 ** np.arange(5 if order == 1 else 4)
    volumes = []
    for step in steps:
        values = {"numerics.integrator": name, "numerics.step": step, "run.end": 2.0}
        volumes.append(simulate(sphere_scene.with_values(values)).history.volume_ratio[-1])
    differences = np.abs(np.diff(volumes))
    fitted, _ = np.polyfit(np.log(steps[1:]), np.log(differences), 1)
    assert fitted == pytest.approx(order, abs=0.12)


def test_euler_methods_bracket_the_solution(sphere_scene, read_table):
    """The rate increases with time: the explicit method is too slow, the implicit one too fast."""
    wanted = float(read_table("sphere_ode.csv")[2]["volume_ratio"])  # at 2 min
    volumes = {}
    for name in ("forward-euler", "backward-euler"):
        values = {"numerics.integrator": name, "numerics.step": 0.125, "run.end": 2.0}
        volumes[name] = simulate(sphere_scene.with_values(values)).history.volume_ratio[-1]
    assert volumes["forward-euler"] < wanted < volumes["backward-euler"]
    assert np.mean(list(volumes.values())) == pytest.approx(wanted, rel=1e-3)


def test_time_enters_only_as_a_fraction_of_the_growth_time(fine_scene):
    """Curves for t_grw = 30, 45 and 60 min are one curve in t/t_grw."""
    curves = []
    for t_grw in (30.0, 45.0, 60.0):
        values = {
            "growth.time": t_grw,
            "run": Run(end=0.6 * t_grw),
            "numerics.step": 0.02 * t_grw,
        }
        history = simulate(fine_scene.with_values(values)).history
        curves.append((history.time_min / t_grw, history.volume_ratio))
    assert curves[0][1][-1] > curves[0][1][0] + 0.03
    for times, volumes in curves[1:]:
        np.testing.assert_allclose(times, curves[0][0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(volumes, curves[0][1], rtol=0, atol=1e-6)


# --- times --------------------------------------------------------------------------------


def test_milestones_are_met_exactly_with_equal_steps_between_them(fine_scene):
    """End of the ramp, saved times and end; the steps between two of them are equal."""
    values = {
        "turgor.ramp": 0.01,
        "run": Run(end=1.7, save=(0.3, 1.0, 1.05, 1.7)),
        "numerics.step": 0.25,
        "numerics.integrator": "backward-euler",
        "numerics.elements": 20,
    }
    result = simulate(fine_scene.with_values(values))
    history, milestones = result.history, [0.01, 0.3, 1.0, 1.05, 1.7]
    times = history.time_min.tolist()
    assert [t for t in times if t in milestones] == milestones
    assert [profile.time for profile in result.profiles] == milestones[1:]
    assert times[0] == 0
    assert history.pressure_MPa[0] == 0
    assert history.volume_ratio[0] == 1
    np.testing.assert_array_equal(history.pressure_MPa[1:], 0.20265)
    np.testing.assert_allclose(np.diff(times), history.step_min[1:], atol=1e-15)
    for start, end in zip([0, *milestones], milestones, strict=False):
        inside = np.diff([t for t in times if start <= t <= end])
        np.testing.assert_allclose(inside, (end - start) / len(inside), rtol=1e-9)
        assert len(inside) == np.ceil(round((end - start) / 0.25, 9))


@pytest.mark.distributed
def test_fixed_steps_have_the_given_size(sphere_scene):
    """Whatever the round-off of their sum."""
    values = {"run.end": 7.0, "numerics.step": 0.1, "numerics.integrator": "backward-euler"}
    times = simulate(sphere_scene.with_values(values)).history.time_min
    assert times[-1] == 7.0
    np.testing.assert_allclose(times, np.linspace(0, 7, 71), rtol=0, atol=1e-12)


# --- failed steps ----------------------------------------------------------------------


@contextmanager
def started(scene, name: str, pressure) -> Iterator[TimeStepper]:
    """A bud after two time steps."""
    shell = build_shell(scene)
    with Equilibrium(shell, TOLERANCE) as equilibrium:
        stepper = TimeStepper(shell, equilibrium, TABLEAUX[name], pressure)
        stepper.load()
        stepper.step(0.5)
        stepper.step(1.0)
        yield stepper


def bits(stepper: TimeStepper) -> list[bytes]:
    """All that a step may change and the next step reads."""
    shell, state = stepper.shell, stepper.accepted
    arrays = [shell.w.x.array, shell.growth.get(), state.w, state.eps_g]
    numbers = [shell.pressure.value, shell.growth.stage.value, state.time]
    return [np.array(item).tobytes() for item in (*arrays, *numbers)]


def overload(time: float) -> float:
    """Turgor beyond the limit pressure from 2 min on."""
    return 0.20265 if time < 2 else 50.0


def interrupt(time: float) -> float:
    """Ctrl-C in the middle of a step, as a late stage asks for its pressure."""
    if time >= 2:
        raise KeyboardInterrupt
    return 0.20265


@pytest.mark.parametrize("name", ["forward-euler", "backward-euler", "sdirk3"])
@pytest.mark.parametrize(
    ("pressure", "error"), [(overload, EquilibriumError), (interrupt, KeyboardInterrupt)]
)
def test_failed_step_leaves_no_trace(fine_scene, name, pressure, error):
    """Bit for bit; the next step has the result that it has without the failed one."""
    with started(fine_scene, name, pressure) as stepper:
        before, state = bits(stepper), stepper.accepted
        with pytest.raises(error):
            stepper.step(2.5)
        assert bits(stepper) == before
        assert stepper.accepted is state
        stepper.step(1.5)
        volume = stepper.shell.volume()
    with started(fine_scene, name, lambda time: 0.20265) as untouched:
        assert bits(untouched) == before
        untouched.step(1.5)
        assert volume == pytest.approx(untouched.shell.volume(), rel=1e-11)


def test_ramp_beyond_the_limit_pressure_ends_at_the_limit_point(fine_scene):
    """Steps in volume approach the limit point of an elastic sphere; all of them are kept."""
    limit = 1.239463 * 40 * 0.1 / 2.5
    values = {
        "turgor.pressure": 2 * limit,
        "turgor.ramp": 1.0,
        "growth.threshold": 1e3,  # nothing grows
        "run": Run(end=2.0),
        "numerics.step": 0.2,
    }
    result = simulate(fine_scene.with_values(values))
    assert result.status == "no-equilibrium" and "limit pressure" in result.message
    assert result.end_time == result.history.time_min[-1] == pytest.approx(0.5, abs=1e-4)
    assert result.profiles.all[-1].time == result.end_time
    assert result.history.volume_ratio[-1] ** (1 / 3) == pytest.approx(7 ** (1 / 6), rel=0.03)
