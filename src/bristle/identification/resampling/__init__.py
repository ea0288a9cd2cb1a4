"""How sure a fit is: fits to twins of the log, to parts of it, and with one parameter moved away."""
