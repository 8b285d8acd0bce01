"""The paper's figures: the runs that they need, the curves, and the table of errors.

Each module of figures has ``runs(quick)``, the runs it draws, and ``draw(results, folder)``.
"""
