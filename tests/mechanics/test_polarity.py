"""Polarised growth: weights around a point of the wall and at the tip, in space and in time."""

import numpy as np
import pytest
from support.scenes import BUD

from fenics_yeast import Scene, simulate
from fenics_yeast.mechanics import Law
from fenics_yeast.mechanics import growth_laws as growth
from fenics_yeast.scene import SceneError
from fenics_yeast.simulation import Simulation, build_shell
from fenics_yeast.simulation.checkpoint import Checkpoint, ResumePoint
from fenics_yeast.solve.equilibrium import Equilibrium

R, LENGTH = 2.5, np.pi * 2.5


@pytest.fixture(scope="module")
def whole(cell_scene: Scene) -> Scene:
    """A sphere that grows everywhere, far above the threshold, on few elements."""
    numerics = {"elements": 24, "order": 4, "thickness_points": 2, "step": 1.0}
    wall = {"shear_modulus": 400.0, "energy_per": "grown"}
    changes = {"growth.zone.half_angle": 180.0, "numerics": numerics, "run": {"end": 4.0}}
    changes |= {f"wall.{key}": value for key, value in wall.items()}
    return cell_scene.with_values(changes)


def first_rates(scene: Scene):
    """Meridional rates of growth in the elastic equilibrium, their arc lengths, the stretch."""
    shell = build_shell(scene)
    unloaded = shell.volume()
    shell.pressure.value = scene.turgor.pressure
    with Equilibrium(shell, 1e-10) as equilibrium:
        equilibrium.solve()
    stretch = (shell.volume() / unloaded) ** (1 / 3)
    S = shell.growing_points.S
    rates = shell.growth.rate().reshape(*S.shape, -1, 2)
    return S[..., None], rates[..., 0], stretch


@pytest.mark.parametrize(
    ("polarity", "centre"),
    [
        ({"width": 1.2}, LENGTH),
        ({"width": 0.7, "pole": "bottom"}, 0.0),
        ({"width": 0.7, "centre": "3 um"}, 3.0),
        ({"width": 0.7, "follow": "tip"}, LENGTH),
        ({"width": 0.7, "follow": "tip", "pole": "bottom"}, 0.0),
    ],
)
def test_rate_falls_off_as_a_gaussian_of_the_arc_length(whole, polarity, centre):
    """Of the unloaded wall around a point; of the wall under turgor at the tip."""
    grid = {"numerics.grading": "uniform", "wall.shear_modulus": 40.0}
    _, even, _ = first_rates(whole.with_values(grid))
    S, rates, stretch = first_rates(whole.with_values({**grid, "growth.polarity": polarity}))
    scale = stretch if polarity.get("follow") == "tip" else 1
    distance = scale * (S - centre) / polarity["width"]
    expected = np.broadcast_to(np.exp(-(distance**2) / 2), rates.shape)
    np.testing.assert_allclose(rates / even, expected, rtol=2e-6, atol=1e-12)
    assert stretch > 1.01


def test_threshold_is_divided_by_the_gaussian(whole):
    """The excess is `w ‖σ‖/σ_trs - 1`; where it is negative, there is no growth."""
    grid = {"numerics.grading": "uniform"}
    _, even, _ = first_rates(whole.with_values(grid))
    polarity = {"width": 1.5, "weight": "threshold"}
    S, rates, _ = first_rates(whole.with_values({**grid, "growth.polarity": polarity}))
    excess = np.sqrt(2) * 45 * even + 1  # the true stress in parts of the threshold
    weight = np.exp(-(((S - LENGTH) / 1.5) ** 2) / 2)
    expected = np.maximum(weight * excess - 1, 0) / (45 * np.sqrt(2))
    np.testing.assert_allclose(rates, expected, rtol=1e-6, atol=1e-9)
    assert 0 < np.count_nonzero(rates) < rates.size


@pytest.mark.parametrize("follow", ["point", "tip"])
@pytest.mark.parametrize("weight", ["rate", "threshold"])
def test_a_very_wide_gaussian_gives_uniform_growth(whole, weight, follow):
    """On the same elements; the weight differs from 1 by (LENGTH / width)²/2."""
    scene = whole.with_values({"numerics.grading": "uniform", "numerics.elements": 12})
    even = simulate(scene).history
    polarity = {"width": "1 m", "weight": weight, "follow": follow}
    wide = simulate(scene.with_values({"growth.polarity": polarity})).history
    np.testing.assert_allclose(wide.volume_ratio, even.volume_ratio, rtol=1e-9)
    assert even.max_growth_strain[-1] > 0.1


@pytest.mark.parametrize("follow", ["point", "tip"])
def test_growth_at_either_pole_is_the_same_upside_down(whole, follow):
    def run(pole):
        polarity = {"width": 1.0, "follow": follow, "pole": pole}
        return simulate(whole.with_values({"growth.polarity": polarity})).profiles.at(4)

    top, bottom = run("top"), run("bottom")
    np.testing.assert_allclose(top.r, bottom.r[::-1], rtol=0, atol=1e-8)
    np.testing.assert_allclose(top.S, LENGTH - bottom.S[::-1], rtol=0, atol=1e-9)
    assert np.abs(np.diff(top.r[[5, -6]])) > 0.05


@pytest.mark.slow
@pytest.mark.parametrize(
    ("integrator", "order"), [("backward-euler", 1), ("sdirk2", 2), ("sdirk3", 3)]
)
def test_methods_keep_their_order_where_weights_follow_the_tip(whole, integrator, order):
    """The weights are those of each stage. Fitted to differences of V/V0 after 4 min."""
    values = {"growth.polarity": {"width": 1.0, "follow": "tip"}, "numerics.integrator": integrator}
    steps = [1.0, 0.5, 0.25, 0.125]
    runs = [simulate(whole.with_values({**values, "numerics.step": step})) for step in steps]
    differences = np.abs(np.diff([run.history.volume_ratio[-1] for run in runs]))
    fitted = np.polyfit(np.log(steps[1:]), np.log(differences), 1)[0]
    assert fitted == pytest.approx(order, abs=0.35)


def test_adaptive_steps_meet_their_tolerance_at_a_tip(whole):
    values = {"growth.polarity": {"width": 1.0, "follow": "tip"}, "numerics.step": None}
    volumes = [
        simulate(whole.with_values({**values, "numerics.tolerance": tolerance})).history
        for tolerance in (1e-4, 1e-7)
    ]
    rough, fine = (history.volume_ratio[-1] for history in volumes)
    assert rough == pytest.approx(fine, rel=1e-4)
    assert len(volumes[0]) < len(volumes[1])


def test_growth_stops_where_the_tip_has_left(whole):
    """Around a point of the wall it continues in all material from there, however far away."""
    fastest = {}
    for follow in ("point", "tip"):
        values = {"growth.polarity": {"width": 0.8, "follow": follow}, "numerics.step": None}
        run = {"end": 40.0, "save": [35.0, 40.0]}
        result = simulate(whole.with_values({**values, "run": run}))
        before, wall = result.profiles
        pieces = np.hypot(np.diff(before.r), np.diff(before.z))
        from_tip = np.append(np.cumsum(pieces[::-1])[::-1], 0.0)
        far = np.interp(wall.S_points, wall.S, from_tip) > 4 * 0.8
        change = wall.growth_strain - before.growth_strain
        fastest[follow] = change[far].max() / change.max()
    assert fastest["tip"] < 10 * np.exp(-(4**2) / 2)  # the side is under more stress than the tip
    assert fastest["point"] > 0.05


def test_polarised_and_uniform_zones_grow_independently(whole):
    """Far from each other; growth of the second starts later."""
    polarity = {"width": 0.5, "follow": "tip"}
    law = {"threshold": 1.0, "time": 45.0}
    zones = [
        {**law, "zone": {"pole": "top", "half_angle": 60}, "polarity": polarity},
        {**law, "zone": {"pole": "bottom", "half_angle": 20}, "from": 2.0},
    ]
    scene = whole.with_values({"growth": zones, "numerics.elements": 40, "run.save": [2.0, 4.0]})
    result = simulate(scene)
    before, after = result.profiles.at(2), result.profiles.at(4)
    below = before.S_points < LENGTH / 2
    assert before.growth_strain[below].max() == 0
    assert after.growth_strain[below].max() > 0.02
    assert before.growth_strain[~below].max() > 0.02


def test_a_users_growth_law_is_weighted_in_space_and_time(whole):
    """Only its rate: it has no threshold that could be weighted."""

    def law(point, speed):
        return speed * point.tau / growth.norm(point.tau)

    own = Law(law, {"speed": 0.01})
    values = {"growth.polarity": {"width": 1.0}, "growth.until": 2.0, "run.save": [2.0, 4.0]}
    scene = whole.with_values({**values, "numerics.thickness_points": 1})
    wall, later = simulate(scene, growth_law=own).profiles
    # Where both stresses are equal, as they are before they have changed much.
    expected = 2 * 0.01 * np.exp(-((wall.S_points - LENGTH) ** 2) / 2)
    size = np.linalg.norm(wall.growth_strain[:, 0], axis=-1)
    np.testing.assert_allclose(size, expected, rtol=1e-3, atol=1e-9)
    np.testing.assert_array_equal(later.growth_strain, wall.growth_strain)
    by_threshold = whole.with_values({"growth.polarity": {"width": 1, "weight": "threshold"}})
    with pytest.raises(ValueError, match="no threshold"):
        simulate(by_threshold, growth_law=own)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["sdirk3", "forward-euler"])
def test_a_resumed_run_equals_an_uninterrupted_one(whole, integrator):
    """To the last digit, from a step in the middle and from the end of growth."""
    values = {"growth.polarity": {"width": 1.0, "follow": "tip"}, "growth.until": 1.0}
    numerics = {"numerics.integrator": integrator, "numerics.step": None}
    run = {"end": 2.0, "save": [1.0, 2.0]}
    scene = whole.with_values({**values, **numerics, "run": run, "wall.shear_modulus": 40.0})
    straight = simulate(scene)
    for stop in (0.3, 1.0):
        kept: list[Checkpoint] = []
        with Simulation(scene, keep=kept.append) as simulation:
            for row in simulation:
                if row.time_min >= stop:
                    break
        before = simulation.result
        start = ResumePoint(kept[-1], before.history.rows, before.profiles.all)
        assert simulate(scene, start=start).history.rows == straight.history.rows
        assert 0 < before.end_time < 2


SCRIPT = """
import numpy as np
from mpi4py import MPI
from fenics_yeast import Scene, simulate
result = simulate(Scene.from_toml('''{scene}'''))
if MPI.COMM_WORLD.rank == 0:
    np.savez("run.npz", **result.profiles.arrays())
"""


def test_growth_at_the_tip_is_the_same_on_one_and_three_ranks(whole, mpirun):
    values = {"growth.polarity": {"width": 1.0, "follow": "tip"}, "run.end": 2.0}
    text = SCRIPT.format(scene=whole.with_values(values).to_toml())
    serial, parallel = (np.load(mpirun(text, ranks) / "run.npz") for ranks in (1, 3))
    np.testing.assert_allclose(parallel["r"], serial["r"], rtol=0, atol=1e-8)
    assert serial["growth_strain"].max() > 0.02


@pytest.mark.parametrize(
    ("polarity", "said"),
    [
        ('{ pole = "top" }', ["growth.polarity.width is missing", "a length > 0"]),
        ("{ width = 0 }", ["growth.polarity.width = 0", "> 0"]),
        ('{ width = 1, weight = "speed" }', ["polarity.weight", '"rate", "threshold"']),
        ('{ width = 1, follow = "nose" }', ["polarity.follow", '"point", "tip"']),
        ('{ width = 1, pole = "top", centre = 3 }', ["polarity.centre = 3", "either pole or"]),
        ('{ width = 1, centre = 3, follow = "tip" }', ["polarity.centre", "the tip is a pole"]),
        ("{ width = 1, centre = 9 }", ["polarity.centre = 9", "meridian's length (7.85398 µm)"]),
    ],
)
def test_invalid_polarity_is_reported_on_one_line(polarity, said):
    text = BUD.replace("[run]", f"polarity = {polarity}\n[run]")
    with pytest.raises(SceneError) as caught:
        Scene.from_toml(text)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    for part in said:
        assert part in message


@pytest.mark.parametrize("follow", ["point", "tip"])
@pytest.mark.parametrize("weight", ["rate", "threshold"])
def test_a_zone_at_both_poles_equals_two_zones(whole, weight, follow):
    """Growth is the same at top and bottom."""
    polarity = {"width": 0.7, "weight": weight, "follow": follow}
    cap = {"half_angle": 60.0}
    law = {"threshold": 1.0, "time": 45.0}
    numerics = {"numerics.elements": 48, "numerics.order": 2}
    changes = {**numerics, "run": {"end": 2.0}}
    growth = {**law, "zone": {"pole": "both", **cap}, "polarity": polarity}
    both = whole.with_values({**changes, "growth": growth})
    by_hand = [
        {**law, "zone": {"pole": pole, **cap}, "polarity": {**polarity, "pole": pole}}
        for pole in ("bottom", "top")
    ]
    one, two = (
        simulate(each) for each in (both, whole.with_values({**changes, "growth": by_hand}))
    )
    assert one.history.volume_ratio[-1] == pytest.approx(two.history.volume_ratio[-1], rel=1e-8)
    strain = one.profiles.at(2).growth_strain[[0, -1]]
    np.testing.assert_allclose(strain[0], strain[1], rtol=2e-3)
    assert strain.min() > 0.04
    assert Scene.from_toml(both.to_toml()) == both


def test_polarity_defaults_to_the_pole_of_its_zone(whole):
    def pole(zone, **values):
        changes = {"growth.zone": zone, "growth.polarity": {"width": 1.0, **values}}
        return whole.with_values(changes).growth.polarity.pole

    cap = {"half_angle": 60}
    assert pole({"pole": "bottom", **cap}) == "bottom"
    assert pole({"pole": "both", **cap}) == "both"
    assert pole({"pole": "both", **cap}, pole="top") == "top"
    assert pole({"from_fraction": 0, "to_fraction": 1}) == "top"
    bottom = whole.with_values({"growth.polarity": {"width": 1.0}}).with_values(
        {"growth.zone.pole": "bottom"}
    )
    assert bottom.growth.polarity.pole == "bottom"
    with pytest.raises(SceneError, match=r'polarity.pole = "both": .*pole = "both"'):
        pole({"pole": "top", **cap}, pole="both")
