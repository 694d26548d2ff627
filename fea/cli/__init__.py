"""One module per command; heavy imports wait until the command is called."""
