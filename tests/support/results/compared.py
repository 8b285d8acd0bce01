"""``pgimp compare`` called in the process."""

import argparse

from pgimp.commands import compare


def call(capsys, first, second, *options):
    """Return the exit status and what is printed."""
    parser = argparse.ArgumentParser()
    compare.add_arguments(parser)
    status = compare.execute(parser.parse_args([str(first), str(second), *options]))
    return status, capsys.readouterr().out
