"""The command ``pgimp``, also as ``python -m pgimp``.

Signals come first, before imports that take longer than all else: until its handler is installed,
any of them kills the process. A run notes them from here on; with the other commands they keep
their usual effect.
"""

import sys

from pgimp import commands, signals

if not commands.COMMANDS.keys() & sys.argv[1:2]:
    signals.install()


def main() -> int:
    """Run the command line.

    Returns
    -------
    int
        The exit status, which signals no longer change.
    """
    try:
        from pgimp import terminal

        terminal.reopen()
        from pgimp import cli

        return cli.main()
    except BaseException as error:  # within the import
        if not (signals.interrupted or isinstance(error, KeyboardInterrupt)):
            raise
        print("pgimp: interrupted", file=sys.stderr)
        return 130
    finally:
        signals.ignore()


if __name__ == "__main__":
    sys.exit(main())
