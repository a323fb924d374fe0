"""Hard cases of this model, one per line, each compared with a reference.

A case ends in a converged answer or with a physical reason. Its reference is a closed form, the
solution of a membrane, a scaling law, or the result of another program: "C++" has two-node elements
with hand-derived tangents on uniform meshes of 480 and 960 elements, extrapolated by their order 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

from closed_forms import MU, H, P, R, balloon, inflated, sphere_burst
from hard_runs import (
    BUD,
    EVEN,
    HALF,
    SPHERE,
    Found,
    buckles,
    bud,
    burst,
    by_a_table,
    deflated_and_back,
    found,
    largest_pressure,
    membrane_error,
    slope,
    stiffness_by_place,
    turgor_off,
    two_poles,
    uneven_mesh,
    until,
    volume,
)

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import Status


@dataclass(frozen=True)
class Case:
    """A hard case.

    Attributes
    ----------
    name, quantity
        Name of the case and of the number that is compared.
    run
        Function that runs it.
    status
        Expected status.
    reference, tolerance
        Expected number and largest absolute difference from it.
    source
        Source of the reference.
    says
        Words that the message must contain.
    """

    name: str
    quantity: str
    run: Callable[[], Found]
    status: Status
    reference: float
    tolerance: float
    source: str
    says: str = ""

    def passes(self, found: Found) -> bool:
        """Return whether status, number and message are as expected."""
        near = abs(found.value - self.reference) <= self.tolerance
        return found.status == self.status and bool(near) and self.says in found.message


CPP = "C++"
BY_EXPONENT = {-4.0: 1.2230437, 0.5: 1.2153239, 8.0: 1.1947674, 12.0: 1.1833314}
CONVERGED = 1.211736  # V/V0 of the bud at 80 min: C++ and a p-version code in NumPy
BACKWARD_SLOPE = 0.00373  # min⁻¹, first-order error of backward Euler at 80 min: C++, 0.05, 0.5 min
# V/V0 at 80 min by steps of backward Euler, extrapolated from 480 to 1920 elements.
BACKWARD = {2.0: 1.205207, 5.0: 1.198643, 20.0: 1.192939}
LIMIT = 93.151  # min: C++, steps of 0.02 min; 93.1122 (480 elements), 93.1416 (960)
LONG = {"numerics.integrator": "backward-euler"}


def loss_of_equilibrium() -> list[Case]:
    cases = [
        Case(
            f"burst, growth time {t:g} min", "t (min)",
            lambda t=t: burst(BUD.with_values({"growth.time": t, **until(200)})),
            "no-equilibrium", LIMIT * t / 45, 0.02 * max(1, t / 45),
            f"{CPP}, t/t_grw", "softened",
        )
        for t in (30.0, 45.0, 60.0)
    ]  # fmt: skip
    changes: dict[str, dict[str, object]] = {
        "steps 0.5 min": {"numerics.step": 0.5},
        "steps 2 min": {"numerics.step": 2.0},
        "60 cubic elements": {"numerics.elements": 60, "numerics.order": 3},
        "κ = 1e6": {"numerics.shear_penalty": 1e6},
        "κ infinite": {"numerics.shear_penalty": float("inf")},
        "a million minutes": until(1e6),
    }
    cases += [
        Case(
            f"burst, {name}", "t (min)",
            lambda change=change: burst(BUD.with_values(until(200) | change)),
            "no-equilibrium", LIMIT, 0.02, CPP, "softened",
        )
        for name, change in changes.items()
    ]  # fmt: skip
    everywhere = {"growth.zone.half_angle": 180.0, **until(200)}
    cases.append(
        Case("zone 180°: burst", "t (min)", lambda: burst(BUD.with_values(everywhere)),
             "no-equilibrium", sphere_burst(), 0.01, "membrane, integral", "softened")
    )  # fmt: skip
    cases += [
        Case(
            f"burst, turgor {name}", "t (min)",
            lambda end=end: burst(BUD.with_values({"turgor.pressure": slope(end), **until(200)})),
            "no-equilibrium", reference, 0.02, f"{CPP}, steps of 0.005 min", "softened",
        )
        for name, end, reference in (("rising", 1.0, 66.980), ("falling", 0.95 * P, 93.760))
    ]  # fmt: skip
    limit = balloon(7 ** (1 / 6), 2.0) * MU * H / R
    by_pressure = {"control": "pressure", "until": {"pressure": 20.0}, "steps": 2}
    for name, change in {
        "static": {"growth": None, "run": None},
        "at once": {},
        "in 0.01 min": {"turgor.ramp": 0.01},
        "in 1e-8 min": {"turgor.ramp": 1e-8},
        "elastic, in 1e-6 min": {"growth": None, "turgor.ramp": 1e-6, **until(1e6)},
        "as a path of two steps": {"growth": None, "run": None, "path": by_pressure},
    }.items():
        scene = BUD.with_values({"turgor.pressure": 2.5, **change})

        def named(scene: Scene = scene) -> Found:
            result = simulate(scene)
            said = result.message.split("limit pressure exceeded (")[-1].split(" MPa")[0]
            return found(result, float(said))

        cases.append(
            Case(f"2.5 MPa, {name}", "limit (MPa)", named, "no-equilibrium", limit, 2e-3,
                 "membrane, λ = 7^(1/6)", "limit pressure")
        )  # fmt: skip
    return cases


def steps() -> list[Case]:
    cases = [
        Case("backward Euler, 0.05 min", "V/V0", bud({**LONG, "numerics.step": 0.05}),
             "finished", 1.21152870, 1e-4, CPP),
        Case("backward Euler, 0.5 min", "V/V0", bud({**LONG, "numerics.step": 0.5}),
             "finished", 1.20985145, 1e-4, CPP),
    ]  # fmt: skip
    cases += [
        Case(
            f"backward Euler, {step:g} min", "V/V0", bud({**LONG, "numerics.step": step}),
            "finished", reference, 3e-5, f"{CPP}, the same steps",
        )
        for step, reference in BACKWARD.items()
    ]  # fmt: skip
    explicit = {"numerics.integrator": "forward-euler"}
    cases += [
        Case(
            f"forward Euler, {step:g} min", "V/V0", bud({**explicit, "numerics.step": step}),
            "finished", CONVERGED, BACKWARD_SLOPE * 0.45, f"{CPP}, error at its limit", "reduced",
        )
        for step in (0.5, 2.0, 20.0)
    ]  # fmt: skip
    cases += [
        Case("steps of 1e-6 min", "V/V0", bud({"numerics.step": 1e-6, **until(1e-4)}),
             "finished", inflated(P), 2e-5, "membrane"),
        Case("μ = 4000 MPa", "V/V0", bud({"wall.shear_modulus": 4000.0}),
             "finished", 1.043435, 1e-4, CPP),
        Case("growth time 0.5 min", "V/V0", bud({"growth.time": 0.5, **until(80 / 90)}),
             "finished", CONVERGED, 1e-4, "t/t_grw"),
    ]  # fmt: skip
    return cases


def walls() -> list[Case]:
    thin = [
        Case(f"elastic, h/R = 1/{n}", "V/V0", membrane_error(1 / n), "finished",
             inflated(P), max((1 / n) ** 2 / 12, 1e-9), "membrane, error below (h/R)²/12")
        for n in (5, 25, 100, 1000)
    ]  # fmt: skip
    exponents = [
        Case(f"elastic, α = {a:g}", "V/V0",
             lambda a=a: volume(SPHERE.with_values({"wall.ogden_exponent": a})),
             "finished", inflated(P, a), 2e-5, "membrane")
        for a in (-4.0, 0.5, 8.0, 12.0)
    ]  # fmt: skip
    growing = [
        Case(f"bud, α = {a:g}", "V/V0", bud({"wall.ogden_exponent": a}), "finished", v, 1e-4, CPP)
        for a, v in BY_EXPONENT.items()
    ]
    same_mesh = {"numerics.elements": 960, "numerics.order": 1, "numerics.grading": "uniform"}
    growing += [
        Case("bud, h/R = 1/5", "V/V0", bud({"wall.thickness": 0.5, "turgor.pressure": 5 * P}),
             "finished", 1.0749909, 1e-4, CPP),
        Case("bud, h/R = 1/125", "V/V0",
             bud({**same_mesh, "wall.thickness": 0.02, "turgor.pressure": P / 5,
                  "numerics.step": 1.0}),
             "finished", 1.3088989, 2e-5, f"{CPP}, on the same 960 elements"),
    ]  # fmt: skip
    return thin + exponents + growing


def zones() -> list[Case]:
    return [
        Case("zone 5°: grows, then stops", "V/V0",
             bud({"growth.zone.half_angle": 5.0, **until(1e6)}), "finished", 1.033874, 1e-5, CPP),
        Case("zone 90°", "V/V0",
             bud({"growth.zone.half_angle": 90.0, "numerics.tolerance": 1e-6, **until(10)}),
             "finished", 2.4281456, 1e-4, CPP),
        Case("zone at the bottom", "V/V0", bud({"growth.zone.pole": "bottom"}),
             "finished", CONVERGED, 1e-4, "mirror image"),
        Case("zones at both poles", "growth ratio", two_poles, "finished", 2, 1e-3, "twice one"),
        Case("threshold never reached", "V/V0", bud({"growth.threshold": 10.0, **until(1e6)}),
             "finished", inflated(P), 2e-5, "membrane", "nothing grew"),
        Case("mother ten times softer", "V/V0",
             bud({**EVEN, **HALF, **until(40)}, energy=stiffness_by_place(MU, MU / 10)),
             "finished", 1.529588, 1e-4, CPP),
        Case("mother ten times stiffer", "V/V0",
             bud(EVEN, energy=stiffness_by_place(MU, 10 * MU)), "finished", 1.055610, 1e-4, CPP),
        Case("μ jumps by 100", "V/V0",
             bud({**EVEN, **until(40)}, energy=stiffness_by_place(100 * MU, MU)),
             "finished", 1.088147, 1e-4, CPP),
        Case("20 elements", "V/V0",
             bud({"numerics.elements": 20}), "finished", CONVERGED, 1e-4, CPP),
        Case("4000 elements", "V/V0",
             bud({"numerics.elements": 4000, "numerics.order": 1, **until(40)}),
             "finished", 1.089066, 1e-4, CPP),
        Case("element sizes of ratio 1000", "V/V0", uneven_mesh, "finished", CONVERGED, 1e-4, CPP),
    ]  # fmt: skip


def loads() -> list[Case]:
    return [
        Case("pressure zero", "V/V0", bud({"turgor.pressure": 0.0}), "finished", 1, 1e-12,
             "at rest", "nothing grew"),
        Case("elastic, external pressure", "V/V0",
             lambda: volume(SPHERE.with_values({"turgor.pressure": -0.1})),
             "finished", inflated(-0.1), 2e-5, "membrane"),
        Case("external pressure, growing", "V/V0 at 0.5 min",
             bud({"turgor.pressure": -0.1, **until(0.5)}), "finished", 0.9840452, 1e-5, CPP),
        Case("buckling, h/R = 1/100", "p/p_cl", lambda: buckles(R / 100),
             "finished", 1, 0.03, "Zoelly 1915", "unstable"),
        Case("buckling, h/R = 1/400", "p/p_cl", lambda: buckles(R / 400),
             "finished", 1, 0.03, "Zoelly 1915", "unstable"),
        Case("balloon over its limit point", "p R/(μ h)", lambda: largest_pressure(2.0),
             "finished", balloon(7 ** (1 / 6), 2.0), 2e-3, "membrane, λ = 7^(1/6)", "limit point"),
        Case("α = 8 has no limit point", "p R/(μ h)", lambda: largest_pressure(8.0),
             "finished", balloon(2.0, 8.0), 0.02, "membrane, λ = 2"),
        Case("bud deflated to 10 % and back", "V/V0 ratio", deflated_and_back, "finished", 1,
             1e-10, "no growth"),
        Case("turgor off from 40 to 50 min", "V/V0", turgor_off, "finished", 1.213753, 1e-4,
             f"{CPP}; residual stresses remain"),
        Case("turgor by a table, elastic", "V/V0", by_a_table, "finished", inflated(0.55 * P),
             2e-5, "membrane"),
    ]  # fmt: skip


def hard_cases() -> list[Case]:
    """Return all cases, in order."""
    return [*loss_of_equilibrium(), *steps(), *walls(), *zones(), *loads()]


def main() -> None:
    """Print the table."""
    cases, failed, total = hard_cases(), 0, 0
    print(f"{'case':34}{'ends':16}{'found':>13}{'reference':>13}{'within':>9}{'its':>7}{'s':>6}")
    for case in cases:
        began = perf_counter()
        outcome = case.run()
        passes = case.passes(outcome)
        failed, total = failed + (not passes), total + outcome.iterations
        print(
            f"{case.name:34}{outcome.status:16}{outcome.value:13.7g}{case.reference:13.7g}"
            f"{case.tolerance:9.1g}{outcome.iterations:7}{perf_counter() - began:6.1f}  "
            f"{case.quantity}; {case.source}{'' if passes else '   <-- not as expected'}",
            flush=True,
        )
    print(f"{len(cases)} cases, {total} Newton iterations, {failed} not as expected")


if __name__ == "__main__":
    main()
