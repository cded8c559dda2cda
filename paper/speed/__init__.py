"""How fast avobench is: kept commands that print ratios, taken side by side in one run."""
