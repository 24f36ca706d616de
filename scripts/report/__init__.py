"""The reports, one module for each command of `evaluate` and one for `benchmark`."""
