"""The published studies, figure by figure: as printed, recomputed as published, and from correct mechanics.

Each source module turns its printed tables into `Row`s. *As published* is the printed formula, including the
error made in evaluating it, applied to the printed intermediate figures; *corrected* comes from the mechanics
of this project. A printed cell must agree with the former to one unit of its last digit, or have an
explanation.
"""
