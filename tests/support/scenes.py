"""Scenes as texts: the documented one with every key, the shortest, and one that runs quickly."""

BUD = """\
title = "S. cerevisiae bud"

[cell]
shape = "sphere"
diameter = "5 um"

[wall]
thickness = "100 nm"
shear_modulus = "40 MPa"
ogden_exponent = 2.0

[turgor]
pressure = "2 atm"
ramp = "0.01 min"

[growth]
zone = { pole = "top", half_angle = 24.0 }
threshold = "1 MPa"
time = "45 min"

[run]
end = "90 min"
save = [40, 70, 90]

[numerics]
preset = "default"
elements = 480
order = 1
grading = "uniform"
geometry = "conical"
thickness_points = 3
shear_penalty = 1000.0
integrator = "backward-euler"
step = "0.2 min"
tolerance = 1e-4
"""

BALLOON = """\
[cell]
shape = "sphere"
diameter = 5
[wall]
thickness = 0.1
shear_modulus = 40
[turgor]
pressure = 0.2
"""

# The forms of the paper's preset, on few cells and with long steps.
SMALL = """\
title = "Test bud"
[cell]
shape = "sphere"
diameter = "5 um"
[wall]
thickness = "100 nm"
shear_modulus = "40 MPa"
[turgor]
pressure = "2 atm"
ramp = "0.01 min"
[growth]
zone = { pole = "top", half_angle = 24.0 }
threshold = "1 MPa"
time = "45 min"
[run]
end = "20 min"
save = [10, 20]
[numerics]
preset = "paper"
elements = 60
step = "2 min"
"""
