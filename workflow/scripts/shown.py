"""Numbers in tables that are read."""


def short(value: float, digits: int = 2) -> str:
    """A number for a table that is read: so many digits, never as a power of ten unless it is tiny."""
    return f"{value:.0f}" if abs(value) >= 10**digits else f"{value:.{digits}g}"
