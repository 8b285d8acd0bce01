"""What a case leaves out of its method is chosen: by body, and for the scene.

`rules` has the one table of choices with their reasons and figures, `facts` what they are chosen
from, `choose` fills them in, `written` puts them into the text of a case file.
"""
