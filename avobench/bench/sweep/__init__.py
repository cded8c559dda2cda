"""The sweep: from what a user asks for to the cells that are carried out."""
