"""Where a simulator and a measurement disagree, and which missing effect explains it."""
