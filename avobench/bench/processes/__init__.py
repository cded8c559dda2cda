"""Cells are carried out in worker processes of this machine, alone or many at once, or on a Dask cluster."""
