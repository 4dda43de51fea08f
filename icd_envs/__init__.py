"""Gymnasium environments for contact-rich manipulation of deformable objects.

Importing this package registers the environments and loads neither MuJoCo nor torch.
"""

from __future__ import annotations

from icd_envs.registration import ENV_IDS, register_env, register_envs

__all__ = ["ENV_IDS", "register_env"]

register_envs()
