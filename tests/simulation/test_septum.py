"""Cell separation: mother and daughter start from the whole cell and then grow separately."""

import numpy as np
import pytest
from support.scenes import BALLOON, BUD

from fenics_yeast import Scene, simulate
from fenics_yeast.scene import SceneError
from fenics_yeast.simulation.separation import pieces

CUT = 70.0


@pytest.fixture(scope="module")
def bud(cell_scene: Scene) -> Scene:
    numerics = {"elements": 16, "order": 4, "thickness_points": 3, "tolerance": 1e-4}
    run = {"end": 76.0, "save": [40.0, CUT, 76.0]}
    return cell_scene.with_values({"numerics": numerics, "septum": {}, "run": run})


@pytest.fixture(scope="module")
def whole(bud):
    return simulate(bud.with_values({"run": {"end": CUT}}))


@pytest.fixture(scope="module")
def parts(bud, whole):
    """Results of the lower and the upper piece."""
    return [simulate(piece, state=whole.profiles.at(CUT)) for piece in pieces(bud, CUT)]


def test_volumes_of_mother_and_daughter_add_up_at_separation(whole, parts):
    volumes = [part.history.volume_um3[0] for part in parts]
    assert sum(volumes) == pytest.approx(whole.history.volume_um3[-1], rel=1e-10)
    assert min(volumes) > 5


def test_separation_changes_no_position_strain_or_stress(bud, whole):
    """Positions, angles, strains and stresses of both pieces are those of the whole."""
    state = whole.profiles.at(CUT)
    for piece in pieces(bud, CUT):
        wall = simulate(piece.with_values({"run.save": [0.0]}), state=state).profiles.at(0)
        nodes = np.abs(state.S[:, None] - wall.S).argmin(axis=0)
        points = np.abs(state.S_points[:, None] - wall.S_points).argmin(axis=0)
        for name in ("r", "z", "psi"):
            found, expected = getattr(wall, name), getattr(state, name)[nodes]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)
        np.testing.assert_allclose(wall.strain, state.strain[points], rtol=0, atol=1e-6)
        np.testing.assert_array_equal(wall.growth_strain, state.growth_strain[points])


def test_the_septum_fixes_the_neck_radius_of_the_daughter(whole, parts):
    """And the daughter grows further, while the volume of the mother is constant."""
    neck = parts[1].history.neck_radius_um
    np.testing.assert_allclose(neck, whole.history.neck_radius_um[-1], rtol=1e-12)
    assert parts[1].history.volume_um3[-1] > parts[1].history.volume_um3[0] + 0.5
    np.testing.assert_allclose(parts[0].history.volume_um3, parts[0].history.volume_um3[0])


def test_pieces_follow_the_pressure_table_of_the_whole_cell(bud, whole):
    """The mother swells when the pressure in that table rises."""
    table = {"time": [0, 72, 74], "value": [0.20265, 0.20265, 0.25]}
    lower, _ = pieces(bud.with_values({"turgor.pressure": table}), CUT)
    assert lower.turgor.pressure.time == (0.0, 2.0, 4.0)
    history = simulate(lower, state=whole.profiles.at(CUT)).history
    assert history.at(2).volume_um3 == pytest.approx(history.volume_um3[0], rel=1e-7)
    assert history.pressure_MPa[-1] == pytest.approx(0.25)
    assert history.volume_um3[-1] > 1.004 * history.volume_um3[0]


def test_an_unloaded_upper_piece_is_a_clamped_cap(bud):
    """The upper piece from its unloaded wall, and the cell of that shape, to 30 min."""
    run = {"run": {"end": 30.0}, "numerics.elements": 40}
    piece = simulate(bud.with_values({**run, "septum.piece": "top"})).history
    cap = {"shape": "cap", "radius": 2.5, "half_angle": 24.0, "edge": "clamped"}
    changes = {"cell": cap, "septum": None, "growth.zone.half_angle": 24.0}
    alone = simulate(bud.with_values({**run, **changes})).history
    assert piece.volume_ratio[-1] == pytest.approx(alone.volume_ratio[-1], rel=1e-5)
    assert piece.volume_ratio[-1] > 1.5


def test_growth_intervals_are_shifted_to_the_time_of_separation(bud):
    lower, upper = pieces(bud.with_values({"growth.from": 10.0, "growth.until": 72.0}), CUT)
    assert upper.growth.span == (0.0, 2.0)
    assert (upper.run.end, upper.run.save) == (6.0, (6.0,))
    past = bud.with_values({"growth.until": 60.0})
    ended = pieces(past, CUT)[1]
    assert ended.growth.span[0] >= ended.run.end
    assert Scene.from_toml(lower.to_toml()) == lower


SCRIPT = """
import numpy as np
from mpi4py import MPI
from fenics_yeast import Scene, simulate
from fenics_yeast.simulation.separation import pieces
scene = Scene.from_toml('''{scene}''')
whole = simulate(scene.with_values({{"run": {{"end": 20}}}}))
state = whole.profiles.at(20) if MPI.COMM_WORLD.rank == 0 else None
volumes = [simulate(piece, state=state).history.volume_um3[[0, -1]] for piece in pieces(scene, 20)]
if MPI.COMM_WORLD.rank == 0:
    np.save("volumes.npy", volumes)
"""


@pytest.mark.slow
def test_pieces_on_two_ranks_have_the_volumes_of_one_rank(bud, mpirun):
    scene = bud.with_values({"run": {"end": 22.0}, "numerics.step": 1.0})
    text = SCRIPT.format(scene=scene.to_toml())
    alone, shared = (np.load(mpirun(text, ranks) / "volumes.npy") for ranks in (1, 2))
    np.testing.assert_allclose(shared, alone, rtol=1e-9)


# --- refused input ------------------------------------------------------------------------


def test_a_state_of_another_wall_is_refused(bud, whole):
    state = whole.profiles.at(CUT)
    lower, upper = pieces(bud, CUT)
    with pytest.raises(ValueError, match=r"use the same table \[numerics\]"):
        simulate(upper.with_values({"numerics.elements": 20}), state=state)
    with pytest.raises(ValueError, match="thickness_points must be 3"):
        simulate(upper.with_values({"numerics.thickness_points": 5}), state=state)
    with pytest.raises(ValueError, match="must be later than the separation"):
        pieces(bud, 76.0)
    with pytest.raises(ValueError, match="whole cell"):
        pieces(lower, 3.0)


def test_a_state_grown_outside_the_growing_zones_is_refused(bud):
    even = {"numerics.grading": "uniform", "numerics.elements": 20, "run": {"end": 5.0}}
    wide = bud.with_values({**even, "growth.zone": {"from_fraction": 0.8, "to_fraction": 1}})
    state = simulate(wide).profiles.at(5)
    narrow = wide.with_values({"growth.zone.from_fraction": 0.9})
    with pytest.raises(ValueError, match="outside the scene's growing zones"):
        simulate(narrow, state=state)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (BALLOON + "[septum]", ["septum.at is missing", "the cell has no bud neck"]),
        (BALLOON + "[septum]\nat = 9", ["septum.at = 9", "meridian's length (7.85398 µm)"]),
        (BALLOON + "[septum]\nat = -1", ["septum.at = -1", "> 0"]),
        (BUD + '[septum]\npiece = "left"', ["septum.piece", '"top", "bottom"']),
        (
            BALLOON.replace('shape = "sphere"\ndiameter = 5', 'shape = "disc"\ndiameter = 5')
            + "[septum]\nat = 1",
            ["septum = {...}", "requires a closed cell; a disc is open"],
        ),
    ],
)
def test_an_invalid_septum_is_refused_in_one_line(text, parts):
    with pytest.raises(SceneError) as caught:
        Scene.from_toml(text)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    for part in parts:
        assert part in message
