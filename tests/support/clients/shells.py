"""bash and zsh, asked for all that they complete a line with.

They get a terminal, insert all completions into the line by a command of their editors, and write
the line to a file. zsh looks the script up in its `fpath`, as docs/first-steps.md says.
"""

import os
import pty
import select
import shlex
import time
from pathlib import Path

from processes import clean_env

BASH = r"""source {script}
bind 'set completion-query-items 0' 'set bell-style none'
show() {{ printf '%s\n' "$READLINE_LINE" >{line}; READLINE_LINE=; printf '%s\n' 'SHO''WN'; }}
bind -x '"\C-xs": show'
bind '"\C-xa": insert-completions'
printf '%s\n' 'REA''DY'
"""
ZSH = r"""mkdir -p {script}.d; cp {script} {script}.d/_pgimp; fpath+=({script}.d)
autoload -Uz compinit; compinit -u -D
zle -C all-matches complete-word _generic
bindkey '^Xa' all-matches
zstyle ':completion:all-matches:*' insert true
zstyle ':completion:all-matches::::' completer _all_matches _complete
show() {{ print -r -- "$BUFFER" >{line}; print -r -- 'SHO''WN'; BUFFER=; zle .accept-line; }}
zle -N show
bindkey '^Xs' show
print -r -- 'REA''DY'
"""
START = {"bash": ["bash", "--norc", "--noprofile", "-i"], "zsh": ["zsh", "-f", "-i"]}
SECONDS = 60.0


class Terminal:
    """A shell on a terminal of its own."""

    def __init__(self, words, folder):
        self.child, self.end = pty.fork()
        if self.child == 0:
            os.chdir(folder)
            os.execvpe(words[0], words, clean_env({"TERM": "dumb", "COLUMNS": "9999"}))

    def type(self, text, until):
        """Type and wait for what the shell says then."""
        os.write(self.end, text.encode())
        heard, latest = b"", time.monotonic() + SECONDS
        while until.encode() not in heard:
            assert time.monotonic() < latest, f"the shell said {heard!r}"
            if select.select([self.end], [], [], 0.2)[0]:
                heard += os.read(self.end, 1 << 16)

    def close(self):
        os.close(self.end)  # which hangs up
        os.waitpid(self.child, 0)


def completions(shell, script: Path, lines, folder: Path):
    """What the last word of each line may be, as a set for each; a folder's name without slash."""
    written = script.with_suffix(".line")
    setting = {"bash": BASH, "zsh": ZSH}[shell].format(script=script, line=written)
    found = {}
    terminal = Terminal(START[shell], folder)
    try:
        terminal.type(setting, "READY")
        for line in lines:
            terminal.type(f"{line}\x18a\x18s", "SHOWN")
            *before, last = shlex.split(f"{line}.")  # with a dot, so that there is a last word
            words = shlex.split(written.read_text())[len(before) :]
            found[line] = {word.rstrip("/=") for word in words} - {last[:-1]}
    finally:
        terminal.close()
    return found
