"""What a set of events is reduced to, and where its covariance is 1."""
