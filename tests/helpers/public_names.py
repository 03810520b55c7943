"""All public names of lumped, of its core and of its themes."""

import inspect

import lumped as lp

THEMES = tuple(
    name
    for name in lp.__all__
    if hasattr(getattr(lp, name), "__path__") and name != "functionals"  # short names, as in ops
)
PLACES = ("lumped", *(f"lumped.{theme}" for theme in THEMES))
PUBLIC = {
    name: getattr(place, name)
    for place in (lp, *(getattr(lp, theme) for theme in THEMES))
    for name in place.__all__
}
FUNCTIONS = {name: thing for name, thing in PUBLIC.items() if inspect.isfunction(thing)}
CLASSES = {name: thing for name, thing in PUBLIC.items() if inspect.isclass(thing)}
