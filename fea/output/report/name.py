"""The name of a report in the folder of its run."""

REPORT = "report.html"
