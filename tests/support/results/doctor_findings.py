"""What a test of the doctor looks at."""

OPEN_MPI = {"version": "4.1", "library": "Open MPI v4.1.4", "files": [], "chooses": True}


def only(findings):
    (finding,) = findings
    return finding
