"""The commented scene that `fenics-yeast new` writes: what there is to choose, and how."""

EXAMPLE = """\
# A scene for fenics-yeast. Bare numbers are µm, MPa, min and degrees; a text carries its unit.
# Lines that begin with "# " and a key show what may be added.
title = "My bud"

[cell]
shape = "sphere"
diameter = "5 um"                 # of the mid-surface

[wall]
thickness = "100 nm"
shear_modulus = "40 MPa"
ogden_exponent = 2.0              # any number but zero; 2 is a neo-Hookean wall

[turgor]
pressure = "2 atm"
ramp = "0.01 min"                 # linear from 0, then held
# Or a turgor that changes, linearly from value to value:
# pressure = { time = [0, 30, 40], value = ["2 atm", "2 atm", "0.5 atm"] }

[growth]                          # leave this table out for a wall that only stretches
zone = { pole = "top", half_angle = 24.0 }
threshold = "1 MPa"               # the stress above which the wall grows
time = "45 min"                   # how fast: the characteristic time

[run]
end = "90 min"
save = [40, 70, 90]               # times whose shapes and stresses are kept

[numerics]                        # may be left out
tolerance = 1e-4                  # wanted relative error of the volume
# preset = "paper"                # the published scheme: its mesh, its steps
# thickness_points = 5            # through the wall
"""
