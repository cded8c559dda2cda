"""The methods: one readable module for each, and the base class that a user's own method derives from."""

from avobench.methods.contract import Estimate, Method, TracePoint, WeightedSample
from avobench.methods.problem import Problem, Simulator

__all__ = ["Estimate", "Method", "Problem", "Simulator", "TracePoint", "WeightedSample"]
