"""An elastic sphere inflated to its limit pressure, compared with the closed form.

Let a sphere of radius R with a wall of thickness h be stretched by λ. Its potential is

    Π(λ) = 4π R² h ψ(λ) - p (4/3) π R³ λ³,    ψ = (μ/2) (2 λ² + λ⁻⁴ - 3)  (neo-Hookean, α = 2)

and Π'(λ) = 0 gives p = h ψ'(λ) / (R λ²), or

    p R / (μ h) = 2 (λ⁻¹ - λ⁻⁷),    V/V0 = λ³.

The pressure has its maximum at λ = 7^(1/6); above it there is no equilibrium. The closed form is
that of a membrane. The shell has a finite thickness, which makes a difference of the order of
(h/R)²/12 = 1.3e-4.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from fenics_yeast import Scene, simulate

scene = Scene.load(Path(__file__).parent / "scenes" / "balloon.toml")
result = simulate(scene)
unit = scene.wall.shear_modulus * scene.wall.thickness / scene.cell.radius  # μ h / R in MPa


def pressure(stretch):
    """Return p R / (μ h) by the closed form."""
    return 2 * (1 / stretch - 1 / stretch**7)


stretch = result.history.volume_ratio ** (1 / 3)
shell = result.history.pressure_MPa / unit
largest = pressure(7 ** (1 / 6))
error = abs(shell - pressure(stretch)).max()
print(f"Largest difference of p R/(μ h) from the closed form: {error:.1e}")
print(f"Limit point: p R/(μ h) = {shell[-1]:.6f}, closed form {largest:.6f}; {result.status}")

figure = Path("out/balloon.png")
figure.parent.mkdir(exist_ok=True)
exact = np.linspace(1, 1.75, 200)
fig, axes = plt.subplots(figsize=(4.8, 3.4), layout="constrained")
axes.plot(exact**3, pressure(exact), color="0.6", lw=3, label="closed form")
axes.plot(result.history.volume_ratio, shell, color="#0072b2", label="shell")
axes.plot([7**0.5], [largest], "x", color="#0072b2", ms=7, mew=1.8, label="equilibrium lost")
axes.set(xlabel="volume V/V₀", ylabel="turgor p R / (μ h)", ylim=(0, None))
axes.legend(loc="lower right", frameon=False)
fig.savefig(figure, dpi=200)
print(f"Turgor against volume: {figure}")
