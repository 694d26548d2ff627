"""The jobs behind the commands: analyse, report, leave the files."""
