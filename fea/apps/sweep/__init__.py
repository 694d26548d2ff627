"""Many rods from one study: plan them, compute each once on many processors, and report sensitivities."""
