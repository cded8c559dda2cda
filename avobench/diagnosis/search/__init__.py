"""Which effects to add to a model that the goodness-of-fit tests reject."""
