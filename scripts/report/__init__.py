"""The reports of `evaluate`, one module for each command."""
