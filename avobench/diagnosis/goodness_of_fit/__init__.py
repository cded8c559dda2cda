"""Tests of a fitted model against events, and where the two disagree."""
