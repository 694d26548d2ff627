"""From a study to its results: prepare, solve, judge, check, refine, sweep, summarise."""
