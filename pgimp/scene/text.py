"""Text from files in messages: one line, printable, and not too long."""


def shown(text: object, most: int = 60) -> str:
    """Return text from a file for people; what could move a terminal's cursor is escaped.

    Parameters
    ----------
    text : object
        What is printed; white space becomes a space.
    most : int
        Characters, after which it is cut off.
    """
    words = " ".join(str(text)[: 4 * most].split())
    line = "".join(
        c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode()
        for c in words
    )
    return line if len(line) <= most else line[: most - 3] + "..."
