"""`python -m fenics_yeast` is the command `fenics-yeast`."""

from .cli import main

main()
