"""What `import avobench` offers, and what the command line is made of: inferences, sweeps, diagnoses, lists."""
