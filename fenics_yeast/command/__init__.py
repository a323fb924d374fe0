"""The command `fenics-yeast`: arguments, what the terminal shows, exit codes.

Nothing imports this room.
"""
