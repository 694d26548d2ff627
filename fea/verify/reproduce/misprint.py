"""Misprints that can be recognised from the printed figure itself."""

from fea.verify.reproduce.printed import decimals
from fea.verify.reproduce.row import Slip


def wrong_digit(printed: str, true: float) -> Slip:
    """Explain a figure with one wrong digit; if more digits are wrong, it is not explained.

    Parameters
    ----------
    printed
        The figure as printed.
    true
        The value that the formula gives.
    """
    places = decimals(printed)
    # Some tables are truncated and some are rounded, so try both.
    for right in (f"{true:.{places}f}", f"{true:.{places + 4}f}"[:-4]):
        wrong = [i for i, (p, r) in enumerate(zip(printed, right, strict=False)) if p != r]
        if len(printed) == len(right) and len(wrong) == 1:
            i = wrong[0]
            text = f"misprint: {printed} instead of {right} ({printed[i]} instead of {right[i]})"
            return Slip(text, float(printed))
    return Slip(f"{printed} is not {true:.{places}f} with one wrong digit", true)
