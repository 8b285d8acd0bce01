"""Parts of laws that several materials share: friction, Hencky strain, equations of state."""
