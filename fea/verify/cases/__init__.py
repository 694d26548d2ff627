"""Benchmark problems, one per file: each module defines `BENCHMARK` and gives the case its name."""
