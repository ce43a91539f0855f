"""How bash asks for completions: by the whole line, and with no space after a word that a value follows."""

from __future__ import annotations

import os
import re

from click.shell_completion import BashComplete, CompletionItem, add_completion_class, split_arg_string

VALUE_FOLLOWS = ("=", ":", "/")  # ends of a word that is typed on
SOURCE = """\
%(complete_func)s() {
    local IFS=$'\\n'
    COMPREPLY=($(env COMP_LINE="${COMP_LINE:0:COMP_POINT}" %(complete_var)s=bash_complete "$1"))
    if [[ ${#COMPREPLY[@]} -gt 0 && ${COMPREPLY[0]} == *[=:/] ]]; then
        compopt -o nospace
    fi
}
complete -o nosort -F %(complete_func)s %(prog_name)s
"""


class LineCompletion(BashComplete):
    """Completion in bash, which takes `crank=60rpm` for three words; here it is one."""

    source_template = SOURCE

    def get_completion_args(self) -> tuple[list[str], str]:
        line = os.environ["COMP_LINE"]
        words = split_arg_string(line)
        begun = "" if not words or line[-1:].isspace() else words.pop()
        # What bash replaces is only what stands behind the last of its word breaks.
        self._kept = re.match(r".*[=:]|", begun)[0]  # type: ignore[index]
        return words[1:], begun

    def format_completion(self, item: CompletionItem) -> str:
        return str(item.value).removeprefix(self._kept)


add_completion_class(LineCompletion)
