"""The published studies figure by figure: printed, recomputed as published, and from sound mechanics.

Each source module turns its printed tables into `Row`s. *As published* is the printed formula with the slip
it was evaluated with, formed from the printed intermediate figures; *corrected* is this project's own
mechanics. A printed cell must agree with the first to one unit of its last digit, or name what happened to
it.
"""
