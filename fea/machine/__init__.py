"""The machine that runs the program: threads, processes, memory limits, time, terminal."""
