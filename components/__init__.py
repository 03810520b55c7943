"""Component library.

Import the rotational and electrical parts, motors, controllers and signals from here; the parts of
straight-line motion have the names of the rotational ones and are in
`lumped.components.translation`.
"""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The component library was imported as {__name__!r}; its name is 'lumped.components'. "
        "Install the project and write 'from lumped.components import ...'."
    )

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
