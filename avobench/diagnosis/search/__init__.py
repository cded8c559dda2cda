"""Which effects to add to a model that the gates reject."""
