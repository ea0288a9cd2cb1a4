"""Constants of the normal distribution."""

NORMAL_95 = 1.96  # half-width of a normal 95 % interval, in standard deviations
DEVIATION_OVER_MEDIAN = 1.4826  # normal standard deviation divided by the median absolute deviation
