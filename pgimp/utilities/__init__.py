"""Tools around runs: studies, figures, batch scripts, the doctor, the performance model."""
