"""The crank cycle of a study in engineering units: columns, extremes, means."""
