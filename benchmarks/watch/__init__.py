"""Look at an agent while it acts: what happens, who controls it and how it is drawn."""
