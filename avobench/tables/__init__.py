"""Published tables in place of events: histograms, unfolded densities, and what simulated events give in their bins."""
