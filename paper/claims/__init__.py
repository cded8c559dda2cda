"""The paper's claims, each with the records that decide it."""
