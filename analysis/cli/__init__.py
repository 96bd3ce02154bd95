"""The `lure` command: thin, no mathematics.  Nothing heavy is imported before a command needs it."""

from analysis.cli.entry import main as main
