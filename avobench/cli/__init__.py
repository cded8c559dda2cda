"""The command `avobench`: the one place that puts all others together; nothing imports it."""
