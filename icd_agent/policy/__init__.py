"""Policies that generate chunks of actions by diffusion: no planner, no simulator."""
