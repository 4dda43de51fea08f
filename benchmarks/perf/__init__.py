"""Timings of the hot path. A GL backend is chosen before MuJoCo loads one."""

from icd_envs.rendering import choose_backend

choose_backend()
