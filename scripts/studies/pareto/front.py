"""Which runs are on the front, and what an error costs with a method."""

from math import exp, log


def usable(record):
    """Whether a run has an error that means something: at a half most of what was asked is lost."""
    return record["error"] is not None and 0.0 < record["error"] < 0.5


def front(records):
    """The runs that no other beats in both error and time, from cheap to dear."""
    best = []
    for record in sorted(filter(usable, records), key=lambda r: (r["seconds"], r["error"])):
        if not best or record["error"] < best[-1]["error"]:
            best.append(record)
    return best


def price(ladder, target):
    """Seconds for an error with one method that finer cells do not exceed; None without.

    Between runs, coarsest first in the `ladder`, the logarithms are taken as linear; what the
    coarsest one beats costs its time.
    """
    good = len(ladder)
    while good and usable(ladder[good - 1]) and ladder[good - 1]["error"] <= target:
        good -= 1
    if good == len(ladder):
        return None
    fine, coarse = ladder[good], ladder[good - 1] if good else None
    if coarse is None or not usable(coarse):
        return fine["seconds"]
    part = log(coarse["error"] / target) / log(coarse["error"] / fine["error"])
    return exp(log(coarse["seconds"]) + part * log(fine["seconds"] / coarse["seconds"]))
