"""Times at which the slopes of a run's curves jump: kinks of the pressure, switches of growth."""

from ..scene import PressureTable, Scene


def switches(scene: Scene) -> list[float]:
    """Return the times in min at which growth begins or ends in a zone."""
    return sorted(time for zone in scene.growing for time in zone.span)


def kinks(scene: Scene) -> list[float]:
    """Return the times in min at which the pressure's slope changes, or growth switches."""
    pressure, end = scene.turgor.pressure, scene.run.end if scene.run else 0.0
    times = pressure.ramps[0] if isinstance(pressure, PressureTable) else ()
    inside = (t for t in (*times, *switches(scene)) if 0 < t < end)
    return sorted([min(scene.turgor.ramp, end), *inside])
