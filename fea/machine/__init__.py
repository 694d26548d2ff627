"""The machine a run happens on: threads, memory limits, time, terminal."""
