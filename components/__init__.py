"""Component library."""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The component library was imported as {__name__!r}; its name is 'lumped.components'. "
        "Install the project and write 'from lumped.components import ...'."
    )
