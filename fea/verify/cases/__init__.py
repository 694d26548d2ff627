"""Benchmark problems, one a file: each module defines `BENCHMARK`, and its name names the case."""
