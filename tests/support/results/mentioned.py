"""What messages must contain, whatever words are between."""


def mentions(text, *parts):
    """Each of these words, numbers and names is in the text; else the test fails."""
    missing = [part for part in parts if str(part) not in text]
    assert not missing, f"{missing} not in: {text}"
