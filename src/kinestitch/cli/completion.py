"""The verb ``completion``: what makes the Tab key know verbs, options and files."""

from __future__ import annotations

import click


@click.command(no_args_is_help=True, short_help="Print the script for Tab completion.")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the script that makes the Tab key complete verbs, options and file names.

    \b
    Put it where your shell finds it, once:
      bash   kinestitch completion bash >> ~/.bashrc
      zsh    kinestitch completion zsh >> ~/.zshrc
      fish   kinestitch completion fish > ~/.config/fish/completions/kinestitch.fish
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(kind(ctx.find_root().command, {}, "kinestitch", "_KINESTITCH_COMPLETE").source())
