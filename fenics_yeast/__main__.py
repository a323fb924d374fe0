"""`python -m fenics_yeast` is the command `fenics-yeast`."""

from .command.main import main

main()
