"""``pgimp report``: a run, or a study, on one page of HTML."""
