"""Published tables in place of events: histograms, unfolded densities, and what a simulator's events give in their bins."""
