"""The reference cases of tests/data/derivatives as models of lumped.

Each function takes the parameters of a file and gives a `Case`: parts of the library where it has
them, else a component of its own with the words of the file as equations.
"""

from . import clutches, contact, friction, smooth, switching

CASES = smooth.case | switching.case | contact.case | friction.case | clutches.case
