"""Stages in a row, and what comes, weakens or enters in them: checks of their entries."""
