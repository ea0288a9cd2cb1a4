"""bristle."""
