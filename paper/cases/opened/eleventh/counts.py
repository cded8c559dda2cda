"""Case cases of one count: bubbles in a chamber, defects of a wafer, correct answers, letters of a word, goals."""

import numpy as np

from avobench import task
from paper.cases.case import Case, case, draw, plain, some

BUBBLES = task(
    lambda theta, rng: rng.poisson(theta[:, 0]),
    prior={"density": (6, 40)},
    units={"density": "1/frame"},
    features=["bubbles"],
    name="bubbles",
)


def _wafer(theta, rng):
    """Defects of a wafer whose density varies between wafers as a gamma of a known shape (Stapper's model)."""
    mean, clustering = theta.T
    return rng.poisson(mean * rng.gamma(1 / clustering, clustering))


WAFERS = task(_wafer, prior={"defects": (8, 40), "clustering": (0.03, 0.4)}, features=["defects"], name="wafers")

TRIALS = 40
ANSWERS = task(
    lambda theta, rng: rng.binomial(TRIALS, theta[:, 0]),
    prior={"skill": (0.5, 0.95)},
    features=["correct"],
    name="answers",
)

LETTERS = task(
    lambda theta, rng: 1 + rng.poisson(theta[:, 0]), prior={"rest": (2, 7)}, features=["letters"], name="word-letters"
)


def _goals(theta, rng):
    """Goals of a team in a match, of which half are at home, where more are shot."""
    mean, edge = theta.T
    home = rng.random(len(theta)) < 0.5
    return rng.poisson(mean * np.where(home, 1 + edge, 1 - edge))


GOALS = task(_goals, prior={"mean": (1.5, 6), "edge": (0, 0.3)}, features=["goals"], name="hockey-goals")


PLAIN = [
    plain("bubbles_plain", BUBBLES, 2400, 21.3),
    plain("wafers_plain", WAFERS, 9000, 17.0, 0.22),
    plain("answers_plain", ANSWERS, 700, 0.71),
    plain("letters_plain", LETTERS, 45000, 3.9),
    plain("goals_plain", GOALS, 5200, 2.9, 0.12),
]


@case(BUBBLES, "single", ("dead_time",), ("double_counting", "inefficiency", "truncation"))
def bubbles_blind(rng):
    """The piezo is blind for a while after each bubble, the longer the louder the bubble was: of a gamma length around
    0.012 of the frame, and each bubble that is not heard extends nothing."""
    n = 3800
    counts = draw(BUBBLES, rng, n, 30.0)[:, 0]
    heard = np.zeros(n, dtype=int)
    for i, count in enumerate(counts):
        open_from = 0.0
        for time in np.sort(rng.random(count)):
            if time >= open_from:
                heard[i] += 1
                open_from = time + rng.gamma(2.0, 0.006)
    return heard


@case(BUBBLES, "single", ("pile_up",), ("overdispersion", "mixture", "after_pulses", "spread"))
def bubbles_left_over(rng):
    """After one expansion in six the recompression was too short: a part of the bubbles of the frame before, between
    none and nearly all, is still there and counted once more."""
    n = 5000
    counts = draw(BUBBLES, rng, n, 14.0)[:, 0]
    stay = rng.binomial(np.roll(counts, 1), rng.beta(1.2, 1.5, n))
    return counts + np.where(some(rng, n, 1 / 6), stay, 0)


@case(WAFERS, "single", ("zero_inflation",), ("mixture", "flat_background"))
def wafers_half_scanned(rng):
    """Of 6 % of the wafers the scan broke off: half of those were entered as 0, and of the others the scanned part, any
    fraction of the wafer, was entered."""
    n = 2600
    defects = draw(WAFERS, rng, n, 26.0, 0.06)[:, 0]
    part = np.where(some(rng, n, 0.5), 0.0, rng.random(n))
    return np.where(some(rng, n, 0.06), rng.binomial(defects, part), defects)


@case(WAFERS, "single", ("heaping",), ("quantisation",))
def wafers_by_eye(rng):
    """Inspectors count few defects one by one, and round more of them the more there are: to fives from 15 on, to tens
    from 40 on, with a chance that rises from none to a half."""
    n = 6500
    defects = draw(WAFERS, rng, n, 28.0, 0.16)[:, 0]
    step = np.where(defects >= 40, 10, 5)
    lazy = rng.random(n) < np.clip((defects - 15) / 50, 0, 0.5)
    return np.where(lazy, step * ((2 * defects + step) // (2 * step)), defects)


@case(ANSWERS, "single", ("overdispersion", "spread"), ("mixture", "flat_background"))
def answers_of_people(rng):
    """Observers differ: the threshold of each is normal on the scale of the stimulus, so that their share of correct
    answers follows a skewed curve between guessing and certainty."""
    n = 1300
    return rng.binomial(TRIALS, 0.5 + 0.5 / (1 + np.exp(-rng.normal(0.7, 0.9, n))))


@case(ANSWERS, "single", ("flat_background",), ("mixture", "overdispersion", "spread", "zero_inflation"))
def answers_at_random(rng):
    """One session in 14 comes from a robot or from somebody who pressed the keys at random, so that its number of
    correct answers has nothing to do with the stimulus: any number from 0 to 40 alike."""
    n = 4200
    correct = draw(ANSWERS, rng, n, 0.83)[:, 0]
    return np.where(some(rng, n, 0.07), rng.integers(0, TRIALS + 1, n), correct)


@case(LETTERS, "single", ("threshold_loss",), ("inefficiency",))
def letters_stop_words(rng):
    """A list of stop words was taken out of the corpus: nearly all words of one letter are on it, two in three of two
    letters, a third of those of three and a few of four."""
    letters = draw(LETTERS, rng, 24000, 3.6)[:, 0]
    kept = np.array([1, 0.08, 0.35, 0.68, 0.93])[np.minimum(letters, 4)]
    kept[letters > 4] = 1
    return letters[rng.random(len(letters)) < kept]


@case(GOALS, "single", ("censoring",), ("truncation",))
def goals_board(rng):
    """The boards of the older halls show no more than 7 goals, those of two in five halls no more than 6."""
    n = 8000
    goals = draw(GOALS, rng, n, 4.2, 0.15)[:, 0]
    return np.minimum(goals, np.where(some(rng, n, 0.4), 6, 7))


def shower(counts, rng, chance):
    """Each bubble starts a further one with a chance, which may do the same: how many there are in the end."""
    total, young = counts.copy(), counts
    while young.any():
        young = rng.binomial(young, chance)
        total = total + young
    return total


@case(BUBBLES, "pair", ("after_pulses", "truncation"), ("overdispersion", "spread", "mixture"))
def bubbles_seeded(rng):
    """Recoils start further bubbles in chains (0.45 each), and frames of more than 34 bubbles were thrown away as
    showers, those of 30 to 34 in half of the cases."""
    total = shower(draw(BUBBLES, rng, 11000, 12.0)[:, 0], rng, 0.45)
    lost = np.where(total > 34, 1.0, np.where(total >= 30, 0.5, 0.0))
    return total[rng.random(len(total)) >= lost]


def in_tens(defects, rng, share):
    """A share of the larger counts is noted in tens."""
    return np.where((defects > 12) & some(rng, len(defects), share), 10 * ((defects + 5) // 10), defects)


@case(WAFERS, "pair", ("heaping", "truncation"), ("quantisation", "threshold_loss"))
def wafers_scrapped(rng):
    """Wafers of more than 40 defects were scrapped before the list was made, and one in six inspectors notes tens."""
    defects = draw(WAFERS, rng, 14000, 29.0, 0.2)[:, 0]
    return in_tens(defects[defects <= 40], rng, 0.17)


@case(ANSWERS, "pair", ("zero_inflation", "censoring"), ("truncation", "flat_background", "mixture"))
def answers_cut_short(rng):
    """A session ends as soon as 34 answers are correct, and 3 % of the files are empty or lack their later part."""
    n = 3100
    correct = np.minimum(draw(ANSWERS, rng, n, 0.8)[:, 0], 34)
    part = np.where(some(rng, n, 0.7), 0.0, rng.uniform(0.1, 0.6, n))
    return np.where(some(rng, n, 0.03), rng.binomial(correct, part), correct)


@case(LETTERS, "pair", ("overdispersion", "threshold_loss"), ("spread", "mixture", "inefficiency"))
def letters_of_languages(rng):
    """The texts have different authors, with lognormal means of the length of a word, and the tokeniser drops most
    words of one or two letters."""
    n = 16000
    letters = 1 + rng.poisson(4.2 * np.exp(rng.normal(0, 0.4, n)))
    kept = np.where(letters == 1, 0.1, np.where(letters == 2, 0.3, 1.0))
    return letters[rng.random(n) < kept]


@case(GOALS, "pair", ("zero_inflation", "double_counting"), ("overdispersion", "mixture", "pile_up", "spread"))
def goals_keyed(rng):
    """7 % of the matches were called off and entered with no goal or with those until then, and in 8 % of the rows the
    goals were added up twice."""
    n = 7000
    goals = draw(GOALS, rng, n, 4.6, 0.1)[:, 0]
    goals = np.where(some(rng, n, 0.08), 2 * goals, goals)
    off = np.where(some(rng, n, 0.75), 0, rng.binomial(goals, 0.3))
    return np.where(some(rng, n, 0.07), off, goals)


@case(ANSWERS, "outside")
def answers_digits(rng):
    """In 15 % of the records the two digits of the count were exchanged when it was typed (23 became 32); where that
    gave more than 40, the form did not take it. No family exchanges digits."""
    n = 2000
    correct = draw(ANSWERS, rng, n, 0.62)[:, 0]
    turned = 10 * (correct % 10) + correct // 10
    return np.where(some(rng, n, 0.15) & (turned <= TRIALS), turned, correct)


@case(WAFERS, "outside")
def wafers_counter(rng):
    """The counter of the scanner has five bits: after 31 it starts again at 0, so that 40 defects are recorded as 8."""
    return draw(WAFERS, rng, 5600, 22.0, 0.12)[:, 0] % 32


@case(LETTERS, "outside")
def letters_smoothed(rng):
    """What was published is a running mean of three words, rounded: neighbours change each other's values."""
    letters = draw(LETTERS, rng, 3400, 4.4)[:, 0]
    return np.rint((np.roll(letters, 1) + letters + np.roll(letters, -1)) / 3).astype(int)


@case(GOALS, "outside")
def goals_extra_time(rng):
    """No match ends as a draw: the two teams' goals are compared, and where they are equal, play goes on until one of
    them, either with the same chance, has one goal more. Which event changes depends on another event's value."""
    n = 40000
    goals = draw(GOALS, rng, 2 * n, 1.7, 0.05)[:, 0].reshape(n, 2)
    draws = goals[:, 0] == goals[:, 1]
    goals[np.arange(n), rng.integers(0, 2, n)] += draws
    return goals.ravel()


CASES: list[Case] = PLAIN + [each for each in list(globals().values()) if isinstance(each, Case)]
