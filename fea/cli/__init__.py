"""The command line: one function per command, which loads what it needs when it is called."""
