"""Units of quantities as they stand in files and reports that exist: none of them may change."""

# Quantity: SI unit on a translational axis, on a rotational axis.
UNITS = {
    "1": ("1", "1"),
    "time": ("s", "s"),
    "frequency": ("Hz", "Hz"),
    "1/time": ("1/s", "1/s"),
    "length": ("m", "rad"),
    "length/time": ("m/s", "rad/s"),
    "length/time^2": ("m/s^2", "rad/s^2"),
    "length/time^3": ("m/s^3", "rad/s^3"),
    "length^0.5/time^1.5": ("m^0.5/s^1.5", "rad^0.5/s^1.5"),
    "force": ("N", "N*m"),
    "force/length": ("N/m", "N*m/rad"),
    "1/length": ("1/m", "1/rad"),
    "length/force": ("m/N", "rad/(N*m)"),
    "force*time/length": ("N*s/m", "N*m*s/rad"),
    "force/time": ("N/s", "N*m/s"),
    "mass": ("kg", "kg*m^2"),
    "travel": ("m", "m"),
    "mass of travel": ("kg", "kg"),
    "force of travel/travel": ("N/m", "N/m"),
    "force of travel*time/travel": ("N*s/m", "N*s/m"),
    "temperature": ("K", "K"),
    "1/temperature": ("1/K", "1/K"),
}
MAGNETIC = {
    "1": "1",
    "time": "s",
    "length": "T",
    "length/time": "T/s",
    "force": "A*m^2",
    "force/length": "A*m^2/T",
    "length/force": "T/(A*m^2)",
    "force*time/length": "A*m^2*s/T",
}
PRODUCTS = (
    "force*time^2/length^2",
    "force/(length*time)",
    "1/(force*time)",
    "force^2/temperature^1.5",
)
"""Some that had no unit while quantities were a list."""
