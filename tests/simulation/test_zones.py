"""Growing zones: several of them, where they lie, and when they grow."""

import numpy as np
import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.mechanics import growth_laws as growth
from fenics_yeast.simulation import build as scene_laws
from fenics_yeast.simulation.discretise import discretise

LENGTH = np.pi * 2.5
EDGE = LENGTH * (1 - 24 / 180)
GROWTH = {"threshold": 1.0, "time": 45.0}


@pytest.fixture(scope="module")
def coarse(cell_scene: Scene) -> Scene:
    """The bud on few elements of the default order, to 30 min in fixed steps."""
    numerics = {"elements": 16, "order": 4, "thickness_points": 3, "step": 2.0}
    return cell_scene.with_values({"numerics": numerics, "run": {"end": 30.0}})


def grown(scene: Scene, *zones: dict[str, object]):
    """Run a scene in which zones grow: a table for each."""
    return simulate(scene.with_values({"growth": [{**GROWTH, **zone} for zone in zones]}))


def test_zones_at_both_poles_grow_a_symmetric_cell(coarse):
    cap = {"half_angle": 24.0}
    scene = coarse.with_values({"numerics.elements": 33})
    result = grown(scene, {"zone": {"pole": "top", **cap}}, {"zone": {"pole": "bottom", **cap}})
    wall = result.profiles.at(30)
    middle = (wall.z[0] + wall.z[-1]) / 2
    np.testing.assert_allclose(wall.r, wall.r[::-1], rtol=0, atol=1e-8)
    np.testing.assert_allclose(wall.z - middle, (middle - wall.z)[::-1], rtol=0, atol=1e-8)
    assert result.history.max_growth_strain[-1] > 0.02
    both = simulate(scene.with_values({"growth.zone": {"pole": "both", **cap}}))
    assert both.history.volume_ratio[-1] == pytest.approx(result.history.volume_ratio[-1], rel=1e-9)


@pytest.mark.parametrize("geometry", ["curved", "conical"])
def test_equal_zones_side_by_side_are_their_union(coarse, geometry):
    """On the same nodes; the edge between the two is a node."""
    halves = {"numerics.grading": "uniform", "numerics.elements": 30, "numerics.geometry": geometry}
    scene = coarse.with_values(halves)
    parts = [{"from_fraction": 0.8, "to_fraction": 0.9}, {"from_fraction": 0.9, "to_fraction": 1.0}]
    one = grown(scene, {"zone": {"from_fraction": 0.8, "to_fraction": 1.0}}).history
    two = grown(scene, *({"zone": part} for part in parts)).history
    np.testing.assert_allclose(two.volume_ratio, one.volume_ratio, rtol=1e-10)
    np.testing.assert_allclose(two.neck_radius_um, one.neck_radius_um, rtol=1e-10)
    assert one.max_growth_strain[-1] > 0.02


@pytest.mark.parametrize(
    "zone",
    [
        {"from": EDGE, "to": LENGTH},
        {"from": f"{EDGE / 1000!r} mm", "to": LENGTH},
        {"from_fraction": 1 - 24 / 180, "to_fraction": 1.0},
    ],
)
def test_a_zone_by_angle_position_or_fraction_is_the_same(coarse, zone):
    cut, same = (discretise(s) for s in (coarse, coarse.with_values({"growth.zone": zone})))
    np.testing.assert_allclose(same.nodes, cut.nodes, rtol=1e-12)
    (part,) = same.growing
    assert (part.start, part.end) == pytest.approx((EDGE, LENGTH), rel=1e-12)


def test_each_zone_has_its_own_threshold_and_time(coarse):
    """One never grows; the other grows as without it, in half the time at half the growth time."""
    top = {"zone": {"pole": "top", "half_angle": 24}, "time": 22.5}
    idle = {"zone": {"from": 1.0, "to": 2.0}, "threshold": 50.0}
    scene = coarse.with_values({"numerics.elements": 40, "numerics.step": 1.0, "run.end": 15})
    result = grown(scene, top, idle)
    alone = coarse.with_values({"numerics.elements": 40, "run.end": 30})
    assert result.history.volume_ratio[-1] == pytest.approx(
        simulate(alone).history.volume_ratio[-1], rel=1e-6
    )
    wall = result.profiles.at(15)
    below = np.abs(wall.growth_strain[wall.S_points < EDGE])
    assert below.max() == 0
    assert result.history.max_growth_strain[-1] > 0.02


@pytest.mark.parametrize("integrator", ["forward-euler", "backward-euler", "sdirk3"])
def test_the_volume_is_constant_after_growth_has_ended(coarse, integrator):
    """A step ends at that time; until then the volume is that of growth without an end."""
    numerics = {"numerics.integrator": integrator, "numerics.step": 0.5}
    scene = coarse.with_values({**numerics, "run": {"end": 8.0, "save": [4.0, 8.0]}})
    always = simulate(scene).history
    history = simulate(scene.with_values({"growth.until": 4.0})).history
    assert history.at(4).volume_ratio == pytest.approx(always.at(4).volume_ratio, rel=1e-9)
    late = history.volume_ratio[history.time_min >= 4]
    assert len(late) > 1
    np.testing.assert_allclose(late, late[0], rtol=1e-9)
    assert always.volume_ratio[-1] > late[-1] + 1e-4


@pytest.mark.parametrize("integrator", ["forward-euler", "sdirk3"])
def test_growth_that_begins_late_is_growth_shifted_in_time(coarse, integrator):
    """With adaptive steps, of which few are taken before growth begins."""
    numerics = {"numerics.integrator": integrator, "numerics.step": None}
    run = {"end": 4.0, "save": [4.0]}
    scene = coarse.with_values({**numerics, "run": run, "numerics.tolerance": 1e-3})
    early = simulate(scene).history
    late = simulate(scene.with_values({"growth.from": 20, "run": {"end": 24}})).history
    assert late.at(20).max_growth_strain == 0
    assert np.count_nonzero(late.time_min <= 20) < 4
    grown = early.volume_ratio[-1] - early.volume_ratio[0]
    assert late.volume_ratio[-1] - late.volume_ratio[0] == pytest.approx(grown, rel=5e-3)


def test_equal_zones_give_constant_parameters_and_no_weight(coarse):
    """Of one zone or several alike; only what differs between zones becomes a function."""
    alike = [{**GROWTH, "zone": {"pole": pole, "half_angle": 24}} for pole in ("top", "bottom")]
    for scene in (coarse, coarse.with_values({"growth": alike})):
        cut = discretise(scene)
        law = scene_laws.zone_law(scene, cut)
        assert law is not None
        assert law.parameters == {"sigma_trs": 1.0, "t_grw": 45.0}
        assert law.function is growth.stress_driven
        assert scene_laws.thickness_ratio(scene.wall, cut) is None
        assert scene_laws.modulus_ratio(scene.wall, cut) is None
    other = coarse.with_values({"growth": [alike[0], {**alike[1], "time": 20.0}]})
    law = scene_laws.zone_law(other, discretise(other))
    assert law is not None
    assert law.parameters["sigma_trs"] == 1.0
    assert callable(law.parameters["t_grw"])
