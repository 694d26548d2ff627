"""Compare results with known answers: benchmarks, published studies, extreme cases, CalculiX."""
