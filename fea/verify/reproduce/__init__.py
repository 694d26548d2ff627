"""Three published studies, figure by figure: as printed, as published, and from correct mechanics."""
