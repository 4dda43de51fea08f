"""The scene descriptor field (paper, "Contact-aware Neural Descriptor Field")."""
