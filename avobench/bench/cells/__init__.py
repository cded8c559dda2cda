"""One inference of the sweep: what identifies it, and how it is carried out."""
