"""Latent diffusion of chains of subgoals, coarse to fine."""
