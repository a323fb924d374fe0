"""The second variation for waves around the axis is that of a surface in three dimensions."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from fenics_yeast import Scene
from fenics_yeast import _dolfinx as dx
from fenics_yeast.simulation import build_shell
from fenics_yeast.solve import Equilibrium

MU, ALPHA, H, KAPPA = 40.0, 3.0, 0.2, 10.0
SCENE = f"""
cell = {{ shape = "spheroid", diameter = 5.0, height = 7.0 }}
wall = {{ thickness = {H}, shear_modulus = {MU}, ogden_exponent = {ALPHA}, energy_per = "PER" }}
turgor = {{ pressure = 0.3 }}
growth = {{ zone = {{ pole = "top", half_angle = 50.0 }}, threshold = 1.0, time = 45.0 }}
run = {{ end = 1.0 }}
[numerics]
elements = 6
order = 1
geometry = "conical"
thickness_points = 2
shear_penalty = {KAPPA}
"""


@pytest.fixture(params=["reference", "grown"])
def shell(request):
    """A grown wall in a random axisymmetric state, not in equilibrium."""
    shell = build_shell(Scene.from_toml(SCENE.replace("PER", request.param)))
    random = np.random.default_rng(5)
    shell.pressure.value = 0.0  # its work is tested below
    shell.w.x.array[:] = 0.03 * random.normal(size=len(shell.w.x.array))
    shell.growth.set(0.1 + 0.05 * random.normal(size=shell.growth.get().shape))
    shell.per_grown = request.param == "grown"
    return shell


def at_middles(S, values):
    """Values and slopes of linear functions in the middles of the elements."""
    return (values[1:] + values[:-1]) / 2, np.diff(values, axis=0) / np.diff(S)[:, None]


def shear_forces(space, values):
    """Values of the discontinuous sub-space, element by element from the bottom."""
    part, places = space.sub(1).collapse()
    S = part.tabulate_dof_coordinates()[:, 0]
    size = part.dofmap.index_map_bs
    return values[np.ravel(places)].reshape(-1, size)[np.argsort(S)]


def potential(shell, variation, v, amplitude, waves, angles=48):
    """Potential without pressure of the wall perturbed by an amplitude times v, in NumPy.

    All is analytic in the amplitude, which may be complex.
    """
    S, dofs = dx.node_dofs(shell.space)
    order = np.argsort(S)
    S, L = S[order], np.diff(S[order])
    mean, slope = at_middles(S, shell.w.x.array[dofs[order]])
    unit = shell.rotation
    _, wave_dofs = dx.node_dofs(variation.space)
    wave, wave_S = at_middles(S, v[wave_dofs[np.argsort(dx.node_dofs(variation.space)[0])]])
    force = MU * H * unit / 4
    Q0 = force * shear_forces(shell.space, shell.w.x.array)[:, 0]
    q = force * shear_forces(variation.space, v)
    curve, middle = shell.discretisation.curve, (S[1:] + S[:-1]) / 2
    R, Phi = curve.radius(middle), curve.angle(middle)

    theta = 2 * np.pi * np.arange(angles) / angles
    cos, sin = np.cos(waves * theta), np.sin(waves * theta)
    basis = np.array([[np.cos(theta), np.sin(theta), 0 * theta],
                      [-np.sin(theta), np.cos(theta), 0 * theta],
                      [0 * theta, 0 * theta, 1 + 0 * theta]])  # fmt: skip  # e_r, e_θ, e_z
    turned = np.array([basis[1], -basis[0], 0 * basis[2]])  # their derivatives by θ
    total = 0
    for i in range(len(L)):
        r, r_S, z_S = R[i] + mean[i, 0], np.cos(Phi[i]) + slope[i, 0], np.sin(Phi[i]) + slope[i, 1]
        psi, psi_S = Phi[i] + unit * mean[i, 2], unit * slope[i, 2]
        a, s, c, b, t = wave[i] * [1, 1, 1, unit, unit]
        a_S, s_S, c_S, b_S, t_S = wave_S[i] * [1, 1, 1, unit, unit]
        cP, sp, cp = np.cos(Phi[i]), np.sin(psi), np.cos(psi)

        def field(parts):
            """A vector field of components along e_r, e_θ and e_z at all angles."""
            return np.einsum("kt,kxt->xt", np.array(parts), basis)

        def by_angle(parts, changes):
            return field(changes) + np.einsum("kt,kxt->xt", np.array(parts), turned)

        one, e = np.ones(angles), amplitude
        position = [r + e * a * cos, e * (s - a) * sin, mean[i, 1] + e * c * cos]
        x_S = field([r_S + e * a_S * cos, e * (s_S - a_S) * sin, z_S + e * c_S * cos])
        moved = [-e * waves * a * sin, e * waves * (s - a) * cos, -e * waves * c * sin]
        x_t = by_angle([position[0], position[1], 0 * one], moved)
        w, w_S = t - b * cP, t_S - b_S * cP
        d = [sp + e * b * cp * cos, e * w * sin, -cp * one + e * b * sp * cos]
        d_S = [psi_S * cp + e * (b_S * cp - b * psi_S * sp) * cos, e * w_S * sin,
               psi_S * sp + e * (b_S * sp + b * psi_S * cp) * cos]  # fmt: skip
        turning = [-e * waves * b * cp * sin, e * waves * w * cos, -e * waves * b * sp * sin]
        D, D_S = field(d), field(d_S)
        D_t = by_angle([d[0], d[1], 0 * one], turning)
        size = np.sqrt((D * D).sum(axis=0))
        D_S = D_S / size - D * (D * D_S).sum(axis=0) / size**3
        D_t = D_t / size - D * (D * D_t).sum(axis=0) / size**3
        D = D / size

        def inner(x, y):
            return (x * y).sum(axis=0)

        x_2, D_2 = x_t / R[i], D_t / R[i]
        membrane = [(inner(x_S, x_S) - 1) / 2, (inner(x_2, x_2) - 1) / 2, inner(x_S, x_2) / 2]
        bending = [inner(x_S, D_S), inner(x_2, D_2) - np.sin(Phi[i]) / R[i],
                   (inner(x_S, D_2) + inner(x_2, D_S)) / 2]  # fmt: skip
        density = 0
        for j in range(2):
            xi = H / 2 * np.polynomial.legendre.leggauss(2)[0][j]
            E = [m + xi * k for m, k in zip(membrane, bending, strict=True)]
            g = growth_at(shell, middle[i], j)
            C = [(1 + 2 * E[0]) * np.exp(-2 * g[0]), (1 + 2 * E[1]) * np.exp(-2 * g[1]),
                 2 * E[2] * np.exp(-g[0] - g[1])]  # fmt: skip
            half, apart = (C[0] + C[1]) / 2, np.sqrt((C[0] - C[1]) ** 2 / 4 + C[2] ** 2)
            squares = [half + apart, half - apart]
            powers = [x ** (ALPHA / 2) for x in squares]
            powers.append((squares[0] * squares[1]) ** (-ALPHA / 2))
            psi_density = 2 * MU / ALPHA**2 * (sum(powers) - 3)
            if shell.per_grown:
                psi_density = psi_density * np.exp(g[0] + g[1])
            density = density + H / 2 * psi_density
        Q1, Q2 = Q0[i] + e * q[i, 0] * cos, e * q[i, 1] * sin
        density = density + Q1 * inner(x_S, D) + Q2 * inner(x_2, D)
        density = density - (Q1**2 + Q2**2) / (2 * KAPPA * MU * H)
        total = total + (density * R[i] * L[i]).mean() * 2 * np.pi
    return total


def growth_at(shell, S, j):
    places = shell.growing_points.S.ravel()
    found = np.flatnonzero(abs(places - S) < 1e-9)
    if not len(found):
        return np.zeros(2)
    return shell.growth.get().reshape(len(places), -1, 2)[found[0], j]


@pytest.mark.parametrize("waves", [1, 2, 5])
def test_second_variation_is_that_of_the_perturbed_surface(shell, waves):
    """By Cauchy's formula on a circle of complex amplitudes, without differences."""
    variation = shell.second_variation
    variation.waves.value = waves
    matrix = dx.create_matrix(variation.form)
    dx.assemble_matrix(matrix, variation.form, [])
    K = matrix.convert("dense").getDenseArray().copy()
    np.testing.assert_allclose(K, K.T, atol=1e-10 * abs(K).max())
    v = np.random.default_rng(waves).normal(size=len(K))
    circle = 1e-2 * np.exp(2j * np.pi * np.arange(8) / 8)
    values = [potential(shell, variation, v, e, waves) for e in circle]
    expected = 2 * np.mean(values / circle**2).real
    assert np.pi * v @ K @ v == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("waves", [1, 2, 5])
def test_pressure_does_the_work_of_the_enclosed_volume(waves):
    """Of a smooth perturbation of a deformed cell, regular at the poles."""
    numerics = SCENE[SCENE.index("[numerics]") :]
    fine = SCENE.replace(numerics, '[numerics]\nelements = 48\ngrading = "uniform"').replace(
        "PER", "reference"
    )
    shell = build_shell(Scene.from_toml(fine))
    curve = shell.discretisation.curve
    end = curve.length

    def profile(S):
        """Radius and height of a deformed cell, and the motions a, s and c."""
        t = np.pi * S / end
        r, z = curve.radius(S) * (1 + 0.2 * np.cos(t)), curve.height(S) + 0.3 * np.cos(2 * t)
        flat = np.sin(t) ** 2
        a = (1.0 if waves == 1 else flat) * (1 + 0.5 * np.cos(t))
        return r, z, a, flat * np.cos(t), flat * (0.4 + np.cos(3 * t))

    S, dofs = dx.node_dofs(shell.space)
    r, z = profile(S)[:2]
    shell.w.x.array[dofs[:, 0]] = r - curve.radius(S)
    shell.w.x.array[dofs[:, 1]] = z - curve.height(S)
    variation = shell.second_variation
    variation.waves.value = waves
    S, dofs = dx.node_dofs(variation.space)
    matrix, v, K = dx.create_matrix(variation.form), [], []
    v = np.zeros(matrix.getSize()[0])
    v[dofs[:, :3]] = np.column_stack(profile(S)[2:])
    for pressure in (0.0, 1.0):
        shell.pressure.value = pressure
        dx.assemble_matrix(matrix, variation.form, [])
        K.append(matrix.convert("dense").getDenseArray().copy())

    points, weights = np.polynomial.legendre.leggauss(60)
    S, theta = end * (points + 1) / 2, 2 * np.pi * np.arange(32) / 32
    step = 1e-5 * end
    near = [np.array(profile(S + i * step)) for i in (-2, -1, 1, 2)]
    slopes = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * step)
    r, z, a, s, c = (x[:, None] for x in profile(S))
    r_S, z_S, a_S, s_S, c_S = (x[:, None] for x in slopes)
    cos, sin = np.cos(waves * theta), np.sin(waves * theta)

    def volume(e):
        """A third of position times normal, in components along e_r, e_θ, e_z."""
        x = np.array([r + e * a * cos, e * (s - a) * sin, z + e * c * cos])
        x_S = np.array([r_S + e * a_S * cos, e * (s_S - a_S) * sin, z_S + e * c_S * cos])
        n = waves
        x_t = np.array([-e * n * a * sin - x[1], x[0] + e * n * (s - a) * cos, -e * n * c * sin])
        density = (x * np.cross(x_t, x_S, axis=0)).sum(axis=0) / 3
        return (density.mean(axis=1) * weights).sum() * np.pi * end

    circle = 0.1 * np.exp(2j * np.pi * np.arange(8) / 8)
    assert volume(0.0) == pytest.approx(shell.volume(), rel=1e-5)
    expected = 2 * np.mean([volume(e) / e**2 for e in circle]).real
    assert -np.pi * v @ (K[1] - K[0]) @ v == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    "cell",
    [
        'shape = "cylinder", diameter = 4, length = 6, edge = "guided"',
        'shape = "sphere", diameter = 5',
    ],
)
def test_without_waves_it_is_the_axisymmetric_second_variation(cell):
    """Of a motion without twist, `s = a` and `τ = β cos Φ`, in an inflated state."""
    scene = Scene.from_toml(f"""
    cell = {{ {cell} }}
    wall = {{ thickness = 0.1, shear_modulus = 40 }}
    turgor = {{ pressure = 0.3 }}
    numerics = {{ elements = 20 }}
    """)
    shell = build_shell(scene)
    with Equilibrium(shell, 1e-9) as equilibrium:
        equilibrium.solve()
    variation = shell.second_variation
    variation.waves.value = 0
    length = scene.cell.curve.length
    values = []
    for space, form in ((shell.space, shell.forms.tangent), (variation.space, variation.form)):
        v = dx.fem.Function(space)
        S, dofs = dx.node_dofs(space)
        part = np.pi * S / length
        a, c, beta = np.sin(part) ** 2, 0.3 * np.sin(2 * part), 0.2 * np.sin(part)
        motion = [a, c, beta]
        if space is variation.space:
            motion = [a, a, c, beta, beta * np.cos(scene.cell.curve.angle(S))]
        v.x.array[dofs] = np.column_stack(motion)
        part, places = space.sub(1).collapse()
        size = part.dofmap.index_map_bs
        v.x.array[np.ravel(places).reshape(-1, size)[:, 0]] = 0.4
        matrix = dx.create_matrix(form)
        dx.assemble_matrix(matrix, form, [])
        rows, columns, entries = matrix.getValuesCSR()
        values.append(v.x.array @ (csr_array((entries, columns, rows)) @ v.x.array))
    assert values[0] == pytest.approx(values[1], rel=1e-9)
