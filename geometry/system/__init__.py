"""What the operating system asks of a program: signals, files that are whole."""
