"""Published machines."""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The published machines were imported as {__name__!r}; their name is 'lumped.models'. "
        "Install the project and write 'from lumped.models import ...'."
    )
