"""What a log does not tell of a fit, and what the fit rests on, as codes and numbers."""
