"""Recorded demonstrations: format, reader, export."""
