"""What effects look like: learned once from random examples, and asked beside the fits."""
