"""Where cells are carried out: worker processes, all cells of a task at once, a Dask cluster."""
