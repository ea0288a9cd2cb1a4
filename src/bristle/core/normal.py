"""Constants of the normal distribution."""

NORMAL_95 = 1.96  # half-width of the interval with 95 % of a normal distribution, in standard deviations
DEVIATION_OVER_MEDIAN = 1.4826  # standard deviation divided by the median of the absolute deviations, in a normal distribution
