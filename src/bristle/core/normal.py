"""Constants of the normal distribution."""

NORMAL_95 = 1.96  # standard deviations to either side, between which 95 % lie
DEVIATION_OVER_MEDIAN = 1.4826  # standard deviation over the median of the absolute deviations
