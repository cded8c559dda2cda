"""What the fast process saves, and where it saves nothing."""

from paper.speed.kernel_rank import rank


def test_the_rank_is_low_with_two_parameters_and_full_with_five():
    assert rank(2, 400) < 150
    assert rank(5, 400) == 400
