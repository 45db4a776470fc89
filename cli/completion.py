"""Shell completion: what can stand at the cursor, and the scripts for bash, zsh and fish.

The command line up to the cursor comes in ``COMP_LINE``. Each line of the answer is a word that can
replace the one at the cursor, a tab, and what it is. Files are looked up here as well, so that all
shells show the same; words that end in ``=``, ``:`` or ``/`` are to be continued, without a space.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import ClassVar

import click
from click.shell_completion import (
    CompletionItem,
    ShellComplete,
    split_arg_string,
)

from cli.options import Word, paths

BASH = """\
%(complete_func)s() {
    mapfile -t COMPREPLY < <(
        COMP_LINE="${COMP_LINE:0:COMP_POINT}" COMP_WORDBREAKS="$COMP_WORDBREAKS" \\
            "$1" completion bash --at-cursor 2> /dev/null)
    [[ ${#COMPREPLY[@]} == 1 && $COMPREPLY == *[=:/] ]] && compopt -o nospace
    return 0
}
complete -o nosort -F %(complete_func)s %(prog_name)s
"""
ZSH = """\
#compdef %(prog_name)s
%(complete_func)s() {
    local line
    local -a ended continued
    for line in "${(@f)$(COMP_LINE="${(j: :)words[1,CURRENT-1]} $PREFIX" \\
        $words[1] completion zsh --at-cursor 2> /dev/null)}"; do
        local value=${line%%%%$'\\t'*}
        local item="${value//:/\\\\:}:${line#*$'\\t'}"
        case $value in
            '') ;;
            *[=:/]) continued+=("$item") ;;
            *) ended+=("$item") ;;
        esac
    done
    (( $#ended )) && _describe -V word ended
    (( $#continued )) && _describe -V word continued -S ''
}
(( $+functions[compdef] )) || { autoload -Uz compinit && compinit -u }
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
    %(complete_func)s "$@"
else
    compdef %(complete_func)s %(prog_name)s
fi
"""
FISH = """\
function %(complete_func)s
    set -l command (commandline -opc)[1]
    COMP_LINE=(commandline -cp | string collect) \\
        $command completion fish --at-cursor 2> /dev/null
end
complete --no-files --keep-order --command %(prog_name)s --arguments "(%(complete_func)s)"
"""
_CURSOR = "\0"


class _Completion(ShellComplete):
    """What is common to the shells."""

    def get_completion_args(self) -> tuple[list[str], str]:
        """The words before the one at the cursor, and the beginning of that."""
        *before, last = split_arg_string(os.environ.get("COMP_LINE", "") + _CURSOR)
        return before[1:], last.removesuffix(_CURSOR)

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem[str]]:
        """Words that can stand at the cursor, whole: with ``--option=`` where that is written."""
        option, equals, value = incomplete.partition("=")
        start = option + equals if equals and option.startswith("-") else ""
        return [
            CompletionItem(start + found.value, help=found.help)
            for item in super().get_completions(args, incomplete)
            for found in _listed(item, value if start else incomplete)
        ]

    def format_completion(self, item: CompletionItem[str]) -> str:
        return f"{item.value}\t{item.help or ''}"


class _Bash(_Completion):
    """bash breaks words at ``=`` and ``:`` too, replaces the last part, and shows no help."""

    name: ClassVar[str] = "bash"
    source_template: ClassVar[str] = BASH

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem[str]]:
        breaks = os.environ.get("COMP_WORDBREAKS", "=:")
        kept = max(incomplete.rfind(character) for character in "=:" if character in breaks) + 1
        found = super().get_completions(args, incomplete)
        return [CompletionItem(item.value[kept:]) for item in found]

    def format_completion(self, item: CompletionItem[str]) -> str:
        # A word is inserted as it is: what the shell would split or expand is escaped.
        return "".join(f"\\{c}" if c in " \t'\"\\$&;|<>()[]{}*?!`#" else c for c in item.value)


class _Zsh(_Completion):
    name: ClassVar[str] = "zsh"
    source_template: ClassVar[str] = ZSH


class _Fish(_Completion):
    name: ClassVar[str] = "fish"
    source_template: ClassVar[str] = FISH


def _listed(item: CompletionItem[str], incomplete: str) -> Iterator[CompletionItem[str]]:
    """A word, or for Click's ``file`` and ``dir`` the files and folders that are meant."""
    match item.type:
        case "file":
            yield from paths(incomplete)
        case "dir":
            yield from paths(incomplete, folders_only=True)
        case _:
            yield item


SHELLS: dict[str, type[_Completion]] = {"bash": _Bash, "zsh": _Zsh, "fish": _Fish}


@click.command()
@click.argument("shell", type=Word(list(SHELLS)))
@click.option("--at-cursor", is_flag=True, hidden=True, help="Answer the script.")
@click.pass_context
def completion(ctx: click.Context, shell: str, at_cursor: bool) -> None:
    r"""Print the completion script of SHELL, to be sourced.

    \b
      source <(drone-cli completion bash)       also in ~/.bashrc
      source <(drone-cli completion zsh)        also in ~/.zshrc
      drone-cli completion fish | source        also in ~/.config/fish/config.fish
    """
    asked = SHELLS[shell](ctx.find_root().command, {}, "drone-cli", "")
    click.echo(asked.complete() if at_cursor else asked.source(), nl=at_cursor)
