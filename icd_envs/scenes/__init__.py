"""PyMJCF builders, one physical thing a file. A GL backend is chosen before one is loaded."""

from icd_envs.rendering import choose_backend

choose_backend()
