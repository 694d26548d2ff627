"""Slips that a printed figure itself gives away."""

from fea.verify.reproduce.printed import decimals
from fea.verify.reproduce.row import Slip


def wrong_digit(printed: str, true: float) -> Slip:
    """Explain a figure with one wrong digit; where more than one is wrong nothing is explained.

    Parameters
    ----------
    printed
        As printed.
    true
        What the formula gives.
    """
    places = decimals(printed)
    # Some tables are truncated and some rounded: the figure may have been either before it was misprinted.
    for right in (f"{true:.{places}f}", f"{true:.{places + 4}f}"[:-4]):
        wrong = [i for i, (p, r) in enumerate(zip(printed, right, strict=False)) if p != r]
        if len(printed) == len(right) and len(wrong) == 1:
            i = wrong[0]
            return Slip(f"misprint: {printed} for {right} ({printed[i]} for {right[i]})", float(printed))
    return Slip(f"{printed} is not {true:.{places}f} with one wrong digit", true)
