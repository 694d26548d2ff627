"""The report: one self-contained HTML page with the whole analysis and the rod in three dimensions."""
