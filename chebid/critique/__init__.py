"""Where a model fails, on what its error depends, which effects explain it, and how surely."""
