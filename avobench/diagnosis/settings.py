"""The numbers that a diagnosis is made with, each with its reason."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class SummarySettings:
    """How events are reduced to shares of bins or, of images, to sums of cells."""

    least_in_bin: int = 12
    """Measured and simulated events of a bin, each counted half: with fewer, shares do not scatter as Gaussians do."""
    few_counts: int = 20
    """Different values of a count up to which each has a bin of its own, as in tables of accidents."""
    least_of_few: int = 5
    """The same as `least_in_bin` of so few: the usual rule for tables (W. G. Cochran, Biometrics 10 (1954) 417)."""
    image_blocks: int = 8
    """Blocks along each axis of an image, at most: 64 in all, as many as the rows and columns of a 32 x 32 image."""
    hit_bins: int = 12
    """Bins of the number of hits of an image, at most: as many as a feature has where there are several."""
    most_numbers: int = 3000
    """Numbers in the summary of features, at most: a covariance of 72 MB. All pairs of 18 features have bins."""
    events_a_number: int = 5
    """Measured events for each number in the summary of several features, at least: the covariance that a model is
    tested with is of three times as many events, and is then known well enough for Hotelling's test."""
    paired: int = 2000
    """Measured events from which pairs of features have bins, 16 each: of fewer events most of them would be empty."""
    numbers_at_once: int = 4_000_000
    """Products of features that are held in memory at once: 32 MB."""
    least_hits: int = 40
    """Hits in all images together for a part of the summary to count: fewer scatter unlike a Gaussian."""
    mixed_in: float = 0.1
    """Share of the simulated events in the covariance: where nothing was measured, what was expected still counts."""
    compared_moves: int = 500
    """Events whose vectors are compared, for what moving them adds to the noise: a relative error of 5 %."""
    rank_tolerance: float = 1e-7
    """Share of the largest eigenvalue of a correlation matrix below which one is rounding: bins sum to one."""


@dataclass(frozen=True)
class FitSettings:
    """How a model is fitted by quadratic surrogates over ever narrower designs."""

    clear: float = 3.0
    """Standard errors by simulation from which a squared slope is one, and a point is worse than another."""
    worse: float = 2.0
    """Standard errors by which the end of a step must be worse than its start, to be given up."""
    extra_rounds: int = 2
    """Rounds that follow a descent that would end at a promise: one to see it, one to see whether it was true."""
    anchor: float = 0.1
    """What moving to the edge of a design costs in Q: it keeps parameters still that the data say nothing about."""
    wall: float = 1e4
    """Slope, in standard errors, of the penalty that keeps a fit within the unit cube: steeper than any summary's."""
    reference_sigmas: float = 25.0
    """Standard errors around a fit over which its model is made known: further than an added effect moves theta."""
    min_sigmas: float = 4.0
    """Half the width of a design, in standard errors, at least: the minimum moves about one of them within it."""
    slope_noise: float = 0.5
    """Standard error of a slope over a design, in units of the slope that is one standard error of the parameter. With
    0.2, hence over wider designs, cubic terms made slopes too steep, and the error of a gamma distribution's shape was
    half of the best possible one. From 1 on the slopes are so noisy that the fit itself scatters."""
    cell: float = 6.0
    """Spacing of the nodes at which events are simulated, at most, in standard errors of a parameter beside the others:
    over so short a way the mean of events is linear, and neighbouring fits use the same events."""
    spanned: float = 0.1
    """Share of what places all over a design tell of the worst known coefficient, that the nodes must tell in order to
    stand for them."""
    identified: float = 5.0
    """Standard errors by which a direction must change the summary across its range to count as identified."""
    dear: float = 5.0
    """Simulated events that an event of a model may take before it is given fewer of them: a detector that records one
    in fifty would else take fifty times as long as all others, to no more than being ruled out."""
    probed: int = 1000
    """Events from which it is told how many that is, to 3 %."""
    compared_twins: int = 10_000
    """Events that are compared one by one with what the same seed makes elsewhere: a relative error of 1 %."""
    shrink: float = 3.0
    """How much narrower a design may be than the one before: a cubic term then falls to a ninth of the linear one."""
    bent: float = 0.1
    """Share of Q that a surrogate may lack for being no better polynomial: less than that hardly moves the minimum.
    Chosen on development cases."""
    narrower: int = 3
    """How often a design is narrowed by `shrink`, at most: to a twenty-seventh."""
    falls: float = 0.5
    """Share of the lack that a narrower design may leave, at most. A cubic term falls to a ninth; noise or a jump
    stays."""
    beyond: float = 0.25
    """Share of where a model is known by which a design may reach beyond that: it is nearly quadratic there too."""
    first_share: float = 0.5
    """Share of where a model is known that a larger one's first design takes up, so that its next ones stay within."""
    least_room: float = 0.05
    """Share of a design that must lie where the model is known: narrowed to less, it would see no slope."""
    searched: float = 0.2
    """How far from where it may be, in cube coordinates, a point is looked for. Chosen on development cases."""
    hopeless_events: int = 10
    """How many times fewer events suffice to see where a point is hopeless. Chosen on development cases."""
    sharpenings: int = 4
    """Rounds of a sharpening, at most. Chosen on development cases."""
    settled: float = 0.5
    """Share of the range of theta over which the last step of a fit looks, at most, to either side: where that is no
    quadratic, it looks less far."""
    inside: float = 0.9
    """Share of a design within which a minimum is believed: further out it may lie beyond."""
    coarse_share: float = 0.5
    """Share of the events of a round, in the rounds before the bins suit what is simulated."""
    narrow_prior: float = 0.05
    """Share of the support, in any parameter, below which the first search for theta keeps to the prior."""
    scans: int = 2
    """Scans from which theta is fitted again before a disagreement is believed: a single one may go astray."""
    far: float = 10.0
    """Chi-squared per degree of freedom beyond which a model is plainly wrong, and a first fit says little about where
    it will end."""
    repeats: int = 4
    """How often the best of these fits is repeated, at most, until it stands still. Chosen on development cases without
    an effect."""
    method_events: int = 160_000
    """Simulated events of a registered method that looks for theta first: its budget in the benchmark."""
    method_share: int = 4
    """One in so many of the simulated events is for such a method, at most: the rest is for the diagnosis."""


@dataclass(frozen=True)
class TestSettings:
    """How goodness of fit is tested, on fitted events, on held-out events, and in regions."""

    shares: tuple[tuple[str, float], ...] = (("summary", 0.8), ("classifier", 0.2))
    """Each test's share of the false alarms: most effects show in the summary, so that it has most of them."""
    dependent_shares: tuple[tuple[str, float], ...] = (("summary", 0.6), ("dependence", 0.2), ("classifier", 0.2))
    """The shares where there are several features."""
    image_shares: tuple[tuple[str, float], ...] = (("summary", 0.6), ("cells", 0.2), ("classifier", 0.2))
    """The shares where events are images."""
    hopeless: float = 1e-12
    """P-value below which no care in the fit helps a model."""
    few: int = 1000
    """Measured events that fewer count as, where a fit is made sharper for its test: by few simulated ones slopes do
    not stand out of the noise, and a parameter that the data know would have its whole range as its error."""
    doubted: float = 0.05
    """P-value of the summary up to which it is tested anew, with the covariance of where the fit ended."""
    strayed: float = 3.0
    """Standard errors from where its covariance is from, at which an accepted fit is tested anew too: its error depends
    on that covariance."""
    plainly: float = 4.0
    """Chi-squared per degree of freedom, in the metric of the measured events, beyond which it is not: no covariance
    makes that right. Chosen on development cases."""
    biased: float = 0.1
    """Share of the scatter of chi-squared, above which what it is too high by for a covariance of few events counts."""
    trees: int = 60
    """Trees of the classifier. Chosen on development cases."""
    leaves: int = 12
    """Leaves of a tree, at most: more than three splits deep, for correlations of three features, which no summary
    sees."""
    check_events: int = 4
    """Simulated events per measured event, for the classifier's expectation: they add a quarter to its variance."""
    grain: float = 1e-6
    """Share of a feature's spread within which the classifier takes values as equal: rounding differs by computer."""
    held_out_share: float = 0.25
    """Share of the measured events that is kept aside: no fit sees them; the gap is measured on them, and they may
    veto."""
    shrunk: float = 1.0
    """Standard errors by which a gap must shrink. More would leave out what is right but weak: on a quarter of the
    events a chi-squared of 40 for it all is one of 10."""
    scattered: int = 2000
    """Simulated events whose vectors are looked at, for how chi-squared scatters where bins hold few events."""
    tail: float = 0.025
    """Probability on either side of an interval of the gap, which thus holds 95 %."""
    rejected_share: float = 0.2
    """Share of alpha at which a model with an effect is rejected: no shape of the catalogue is exactly right."""
    draws: int = 2000
    """Draws without any disagreement: the smallest global p-value that they can tell is 1/2001."""
    regions: int = 6
    """Regions that are told, at most: more of them say that the whole feature disagrees."""


@dataclass(frozen=True)
class OrderSettings:
    """How the order of events is tested."""

    lags: tuple[int, ...] = (1, 2, 4, 8, 16, 32, 64)
    """Events apart, of which it is asked whether they are alike: doubling, since neighbouring lags say the same."""
    least_cycles: int = 2
    """Cycles of a season within the data: fewer cannot be told from a drift."""
    most_bins: int = 2**20
    """Bins of the order or the time, for the periodogram: what bounds its time and memory."""
    in_interval: int = 10
    """Events, on average, in an interval of the time in which they are counted: enough for a rate to show."""
    same_ranks: float = 0.9
    """Correlation of ranks from which the spread of a feature says no more than its level, as of rare counts."""
    clipped: float = 0.01
    """Share of the values at either end that count as the last one before, where a size is measured."""


@dataclass(frozen=True)
class SearchSettings:
    """Which effects are screened, where their fits begin, and which fits go on."""

    strengths: tuple[float, ...] = (0.001, 0.005, 0.02, 0.08, 0.25, 0.7)
    """Grid of a strength, as shares of its range; between them the effect is taken as linear."""
    moved_events: int = 100
    """Events of each point, from which the share of events that change bins is taken."""
    locations: int = 12
    """Grid points of a location: what is narrower than a twelfth of the range is found by `Sample.places`."""
    shapes: int = 8
    """Grid points of a single shape parameter. Chosen on development cases."""
    widths: int = 3
    """Grid points of a width beside a location: narrow, middling and wide."""
    points: tuple[int, int] = (20, 50)
    """Points among which the events of a look are divided, at least and at most."""
    dear_events: int = 2
    """Times the events of the first look, for the second, of effects for which each event is simulated anew."""
    final_events: int = 5
    """Times the events of the first look, for the second: as many again in all, since a grid has some 100 points."""
    looks: tuple[tuple[int, float], ...] = ((6, 1 / 2), (3, 1 / 4))
    """Best points of a look beside which the next one looks, and how far from them, in steps of the grid: an edge must
    be met within a fit's first design."""
    followed: int = 4
    """Steps of theta and the strength to where they fit best beside an effect: the next ones move them no more."""
    moved: float = 3.0
    """Standard errors of theta from which an effect is looked at once more, with events of where theta then is."""
    again: int = 8
    """Shapes, the most promising ones, that are looked at once more for that: as many as are left of all fits."""
    shares: tuple[float, ...] = (1.0, 0.4)
    """Shares of the way from the model without an effect to where its fit is to begin, at which events are simulated
    until it is better than without. Chosen on development cases."""
    gain: float = 3.0
    """How far a strength may be moved from its grid point by linearity: to about the next point of `strengths`."""
    looked_at: int = 3
    """Times as many shapes as fits that begin are looked at more closely. Chosen on development cases."""
    approached: int = 5
    """Places, the start among them, at which events are simulated on the way to where theta and an effect fit together:
    on carl an offset that theta takes up takes four. Chosen on development cases."""
    stride: float = 0.1
    """Step of a parameter, in cube coordinates, at most, where slopes of elsewhere are followed: they bend."""
    absorbed: float = 0.3
    """Share of an effect's signal below which theta hides it, so that it is also looked for where it is strong. Chosen
    on development cases."""
    of_one_feature: int = 32
    """Effects of a catalogue, at most, where theta may hide one that is weak: several features tell them apart."""
    weak: tuple[float, ...] = (0.05, 0.1)
    """Strengths, as shares of the range, at which it is found out whether theta hides an effect: above the noise."""
    strong: tuple[float, ...] = tuple(np.linspace(0.1, 1, 10).tolist())
    """Strengths, as shares of the range, at which an effect that theta hides is looked for: the rest of the range."""
    most_features: int = 15
    """Features on which effects are looked for, at most: shapes that tie two of them grow with the square of their
    number, and 15 have 2 900 shapes, which is minutes. Of events with more features a look takes longer, and they are
    fewer, so that the search does not."""
    apart: float = 0.3
    """Distance, in cube coordinates, of thetas that are drawn around others at first, and the factor by which it falls
    in two rounds."""
    pairings: int = 6
    """Rounds in which thetas are drawn around those of the best pairs."""
    pairs: int = 12
    """The best pairs of thetas, around which others are drawn."""
    modes: int = 2
    """Places at which a fit begins that were found in this way, at most, to either side."""
    coarse_points: int = 10
    """Points of theta a parameter, in each search for it beside a strength; the last strength's theta is not far."""
    stepped: int = 2
    """Linear steps of theta that follow such a search. Chosen on development cases."""
    rough: float = 0.5
    """How far a strength from a grid may be off, as a share of it: the steps of the grid are factors of three to
    five."""
    guessed: float = 0.003
    """How far a strength that is read off the data may be off, as a share of it: an edge, known to about one event."""
    furthest: float = 0.2
    """How far, in cube coordinates, theta follows an effect's strength within a first design, so that it stays inside
    the cube."""
    first_half: float = 0.08
    """How far off, in cube coordinates, the shape of an effect from a grid may be: beside `locations`."""
    first_rounds: int = 3
    """Rounds of a fit that begins; enough to tell the promising ones."""
    likeness: float = 4.0
    """Log evidence that a unit of log likeness counts for, while fits go on. Chosen on development cases."""
    alike: float = 4.0
    """Log evidence that each further shape of an effect must be worth more, to be fitted in place of another effect:
    half of `SCORE.indifferent`."""
    parents: int = 3
    """Families that stay although they do not matter: to which a further effect may be added."""
    most: tuple[int, ...] = (8, 6, 6)
    """Candidates that are left after each round of halving, at most. Chosen on development cases."""
    shapes_kept: int = 3
    """Shapes of each family in which fits go on: the plainest may be right, or need a parameter more, and families of
    many shapes must not crowd out the others."""
    not_much_worse: float = 2.0
    """The factor of the chi-squared of the best shape of a family up to which others are kept there."""
    astray: int = 6
    """First fits, the best ones, that are looked for all around where they have so far to go. Chosen on development
    cases, as the three numbers beside it."""
    all_around: float = 0.5
    """How far from such a fit, in cube coordinates, a better one is looked for."""
    nearby: float = 0.05
    """Distance in cube coordinates below which fits of one shape are one. Chosen on development cases."""


@dataclass(frozen=True)
class ScoreSettings:
    """How evidence becomes a probability of each set of effects."""

    indifferent: float = 8.0
    """Difference of log evidence from which a model no longer matters beside another, and what a further effect costs
    at least: its strength, and its place among all sets. Chosen on development cases."""
    weakest: float = 0.001
    """Share of the range of a strength from which its prior is log-uniform: effects are weak more often than strong."""
    number: tuple[float, ...] = (0.1, 0.5, 0.15, 0.03)
    """Prior, once a disagreement is shown, that no, one, two or more effects are missing. Chosen on development
    cases."""
    credible: float = 0.95
    """Probability of the smallest set of models that is told, among those that were weighed."""
    decision: tuple[float, ...] = (0.428, 0.323, 0.843, -0.324, 0.156, 0.621, 0.338)
    """Weights of the covariates of a set of effects, see `posterior.covariates_of`. This and the three below are a
    conditional logit of what was missing in data sets with a known answer, by `python -m paper.tables.decision`."""
    families: dict[str, float] = field(
        default_factory=lambda: {
            "quantisation": 1.01,
            "overdispersion": 0.81,
            "zero_inflation": 0.49,
            "edge_acceptance": 0.49,
            "resolution": 0.39,
            "inefficiency": 0.33,
            "conditional_response": 0.22,
            "saturation": 0.21,
            "correlation": 0.18,
            "crosstalk": 0.18,
            "spread": 0.13,
            "mixture": 0.10,
            "dead_time": 0.06,
            "radiative_tail": 0.02,
            "outliers": -0.01,
            "threshold_loss": -0.03,
            "censoring": -0.04,
            "charge_misid": -0.05,
            "readout_noise": -0.26,
            "forward_backward_acceptance": -0.26,
            "dead_region": -0.27,
            "second_exponential": -0.28,
            "double_counting": -0.31,
            "truncation": -0.53,
            "pile_up": -0.54,
            "scale": -0.59,
            "flat_background": -0.61,
            "offset": -0.62,
            "peak_background": -0.78,
        }
    )
    """Log weight of each family: some are missing more often than others. Fitted with `decision`."""
    others: float = -5.206
    """Log weight of all sets of effects that were not weighed."""
    outside: float = -4.156
    """Log weight of what is outside the catalogue, beside what the events look like."""
    calibrated: tuple[int, int] = (269, 34)
    """Data sets to which these were fitted, and those of them in which what is missing was outside the catalogue."""
    special: int = 5
    """Place in the list of its family from which a shape is no plainer than those after it."""
    sized: float = 2.0
    """Standard errors from which the size of an effect is not compatible with none."""
    chance: float = 0.01
    """Probability by chance of what an effect of a smaller size explains, up to which it counts nevertheless: the size
    and the shape of an effect may be known together alone."""
    tried: int = 3
    """Sets of effects, at most, that are fitted for the answer until each effect of one counts."""


@dataclass(frozen=True)
class RecognitionSettings:
    """What of measured events is compared with simulated ones, by networks that were trained with these numbers."""

    bin_shares: tuple[float, ...] = tuple(
        np.r_[
            0, 1e-4, 1e-3, 3e-3, 0.01, 0.03, np.linspace(0.06, 0.94, 23), 0.97, 0.99, 0.997, 0.999, 0.9999, 1
        ].tolist()
    )
    """Shares of the simulated events, between which measured ones are counted: the tails finely."""
    equal_bins: int = 30
    """Equal bins over nearly all that is simulated, beside those of equal shares: peaks and edges are narrow there."""
    fine_bins: int = 400
    """Bins of equal shares in which steps are looked for, at most."""
    quantiles: tuple[float, ...] = (0, 0.01, 0.16, 0.5, 0.84, 0.99, 1)
    """Quantiles that are compared in standard deviations of the simulated events: the ends, 1 and 2.3 sigma."""
    steps: tuple[int, ...] = (2, 3, 4, 5, 8, 10)
    """Steps in which counts may have been rounded."""
    quarters: tuple[float, ...] = (0.25, 0.5, 0.75)
    """Quantiles at which two features are cut, to see how they go together."""
    added_variance: int = 5
    """Events that are added to the variance of a bin: where next to nothing is expected, a few say little."""
    most_pull: float = 60.0
    """Standard deviations beyond which a bin tells no more."""
    most_deviation: float = 20.0
    """Standard deviations at which single values and moments are clipped."""
    portrait_events: int = 50_000
    """Measured events of a portrait, at most: the networks were trained with no more."""
    simulated: int = 2
    """Simulated events per measured event, beside which those are looked at, as in training."""
    floor: float = 0.1
    """Added to the probability of each family: experience excludes none, since simulators may be unlike those it was
    had with."""
    least_count: float = 5.0
    """Mean of counts below which there is no experience: on the nineteen opened cases of fewer it was no help."""


@dataclass(frozen=True)
class ReportSettings:
    """What is quoted of the fits, and what is drawn."""

    power: float = 0.9
    """Probability with which the smallest strength on the identifiability card is seen: a usual power of a test."""
    shown: float = 3.0
    """Times the scatter of the simulated events, from which a difference on the card is one."""
    parts: tuple[int, ...] = (16, 4, 2, 1)
    """Parts of the events at a fit, by which the card asks in turn whether a strength is seen. Effects for which each
    event is simulated anew are not asked with the last one."""
    compared_moves: int = 10_000
    """Events, at most, from which it is taken on the card how many of them an effect moves: it may be few."""
    followed: float = 0.6
    """Share of the design around a fit within which theta is followed: further out, what simulation leaves open of the
    slopes and bends is as much as a test sees."""
    weakest: float = 1e-5
    """Weakest strength on the card, as a share of its range."""
    bisections: int = 8
    """Steps in which a strength on the card is found: to a twentieth, from a hundred thousandth of its range on."""
    unsure: float = 0.5
    """Standard error by simulation, in what it takes to be seen, above which the card says nothing of an effect."""
    plainer: float = 3.0
    """Times the smallest strength seen, at which what two effects leave is compared: far above the noise."""
    rivals: float = 0.95
    """Correlation of what two effects leave after the fit, from which they are rivals. Chosen on development cases."""
    allowed: float = 4.0
    """Chi-squared above the best up to which another shape is allowed: two standard errors."""
    refitted: int = 4
    """Other shapes that are fitted once more, at most: those that move theta furthest."""
    compared: int = 3
    """Events, per measured event, from which it is taken how far another theta is away: to a standard error at most."""
    compared_events: int = 50_000
    """The same at most, as many as a data set of the challenge has."""
    few_events: int = 1000
    """Measured events below which a summary has so few bins that it is worth a word."""
    faint: float = 10.0
    """Chi-squared per degree of freedom below which, in the challenge, effects that were taken out of the catalogue
    were often explained by others, and above which they seldom were (docs/challenge.md)."""
    map_events: int = 4
    """Simulated events per measured event, for the maps of cells: they add a quarter to the variance of a pull."""
    prior_sigmas: float = 5.0
    """Standard errors to either side of the fit that the prior of an effect's parameter reaches in model.json."""
    least_prior: float = 0.01
    """The same at least, as a share of the parameter's range."""


@dataclass(frozen=True)
class BudgetSettings:
    """How many events are measured and simulated, and how the effort is fitted to a limit."""

    least_events: int = 50
    """Measured events below which there are no bins to speak of."""
    most_events: int = 2_000_000
    """Measured events that are compared, a random sample of more: its errors are far below what a simulator is trusted
    to, and it bounds memory and time."""
    coarsest: float = 0.5
    """Least share of events of the fits that go on: by fewer, all that they tell would be noise."""
    usual_events: int = 50_000
    """Measured events to which `usual` refers: as many as a data set of `avobench challenge` has."""
    usual: tuple[tuple[str, int], ...] = (("counts", 6_000_000), ("continuous", 7_000_000), ("images", 1_500_000))
    """Simulated events that are mostly enough for a diagnosis of so many, by domain. Of the sixteenth series three of
    four diagnoses of counts took less, and half of the others. That of images is of the challenge."""
    step: float = 0.8
    """The factor by which the effort is made less until it fits."""
    with_checks: float = 1.06
    """The factor of the events of the first fit and the tests that also pays for the checks before them: a twentieth of
    what is allowed, and some."""
    least_share: float = 1e-3
    """Share of the effort below which all is at its least."""
    rounds: int = 6
    """Rounds of the fits of theta, in events that are simulated: most rounds find those of others."""
    scans: int = 4
    """Events of a scan of theta, in those of all its points: three searches, each with a tenth more."""
    tests: int = 4
    """Events of the tests beside those of a sharpening, per measured event. Most find those of the fit."""
    sure: float = 3.0
    """Events of the last fit of theta before a disagreement is believed, per measured event, at least. Chosen on
    development cases without an effect, under limits."""
    added: int = 12
    """Events that are kept for the fit and the tests of an effect that was chosen, per measured event: most were
    simulated when it was looked for."""
    refined: int = 8
    """Rounds of the fit of an effect that was chosen, at most."""


@dataclass(frozen=True)
class DecideSettings:
    """How a diagnosis says what would tell models apart."""

    confidence: float = 0.95
    """Probability with which the right one of two models has the smaller chi-squared, once they are told apart."""
    pieces: int = 64
    """Pieces of simulated events, at most: their scatter is the error by simulation, known to a tenth."""
    fewest: int = 6
    """Pieces at least."""
    in_piece: int = 8
    """Measured events, in those of a piece: all pieces together are as many as the last fits simulate."""
    least: int = 100
    """Events of a piece at least, to spare time."""
    asked: int = 8
    """Simulated events that may be asked for a condition, in those of a model: those of slopes lie elsewhere, and
    rejected ones are replaced."""
    shapes: int = 3
    """Shapes of each model beside which the first is seen, at most: as many as a search keeps of a family."""
    most: float = 1e12
    """More events than anybody measures, from which models count as the same."""


SUMMARY, FIT, TEST, ORDER = SummarySettings(), FitSettings(), TestSettings(), OrderSettings()
SEARCH, SCORE, RECOGNITION = SearchSettings(), ScoreSettings(), RecognitionSettings()
REPORT, BUDGET, DECIDE = ReportSettings(), BudgetSettings(), DecideSettings()
