"""Prints the version, if all files name the same one; with tags of a commit, also if one is it."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from recipes import versions


def main(tags: Sequence[str]) -> int:
    """Print the version, or what is wrong with it.

    Parameters
    ----------
    tags : sequence of str
        The tags of the commit to be released; empty: they are not looked at.
    """
    found = versions()
    version = found["pyproject.toml"]
    wrong = [f"{path} has version {other}, pyproject.toml {version}"
             for path, other in found.items() if other != version]  # fmt: skip
    if tags and f"v{version}" not in tags:
        wrong.append(f"the commit has no tag v{version}, but {', '.join(tags)}")
    print("\n".join(f"release: {line}" for line in wrong) or version)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
