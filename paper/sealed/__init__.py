"""Cases from many fields with the answers that were written down first, written without sight of the code."""
