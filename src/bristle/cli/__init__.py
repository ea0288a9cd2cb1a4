"""bristle for a person at a terminal: one module a command."""
