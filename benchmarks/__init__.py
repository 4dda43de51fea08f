"""Honest tables: episodes as rows, results that resume, intervals, difficulty gates."""
