"""Latents: object states as short vectors, and how many steps lie between two of them."""
