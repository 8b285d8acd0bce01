"""Words and signs of a case file that are not what they seem: other programs' names, lookalikes."""
