"""The harness: budget, problem, cells, runner, store, conformance checks, command line."""
