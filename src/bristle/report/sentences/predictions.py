"""What there is to know of a prediction."""

from __future__ import annotations

from bristle.report.sentences.sentence import Sentence, plural, says

__all__ = ["PREDICTIONS"]

PREDICTIONS: dict[str, Sentence] = {
    "position_worse_than_none": says(
        "a position of zero would be nearer to the log than what the model predicts ({percent:2 digits} % off): an "
        "open "
        "loop runs away where nothing holds the axis; predict in inverse or closed-loop mode",
        "the predicted position is worse than none",
        "predict in another mode",
    ),
    "effort_worse_than_none": says(
        "an effort of zero would be nearer to the log than what the model predicts ({percent:2 digits} % off): check "
        "that the model is of this axis, and units and signs in the axis file",
        "the predicted effort is worse than none",
        "check model, units and signs",
    ),
    "beyond_speed": says(
        "the log moves at up to {speed:length/time}, the model was fitted to no more than {fitted_speed:length/time}: "
        "beyond, its friction is an extrapolation",
        "the log is much faster than the one that was fitted",
        "fit the model to faster motion",
    ),
    "presliding_distance": says(
        "friction turns over a pre-sliding distance of {distance:length} (axis file)",
        "a static model was simulated with the pre-sliding distance of the axis file",
    ),
    "short_stretch": says("a stretch of {samples} samples is too short to be predicted, and was left out", "a stretch was left out"),
    "start_of_contact": says(
        "the contact began at {percents:percents} of the way from its middle to slip (below 0: backward), found from the first samples",
        "where the contact stood before each stretch",
    ),
    "slow_sampling": says(
        "the log is sampled too slowly for the filter of the identification, {wanted:g} Hz: {cutoff:.3g} Hz in its place",
        "the cut-off is lower than that of the identification",
        "sample faster",
    ),
    "filtered_rows": Sentence(
        (
            "effort and motion are filtered at {cutoff:g} Hz",
            "effort and motion are filtered at {cutoff:g} Hz, and one row is kept for {decimation} samples",
        ),
        "how the log was filtered for the prediction",
        "nothing",
        choose=plural("decimation"),
    ),
    "begins_at_rest": says("the motion begins at rest", "how the motion begins"),
    "run_in": Sentence(
        (
            "the log is one period of a motion that has run in: it is run from rest until it repeats itself",
            "the log is {periods:g} equal periods of a motion that has run in: it is run from rest until it repeats itself",
        ),
        "the motion was run until it repeats itself",
        "nothing",
        choose=plural("periods"),
    ),
}
