# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 hst VERB``: the same verbs from ROS 2's own command line."""
import argparse

from hst_drive.cli import main, overview
from ros2cli.command import CommandExtension


class HstCommand(CommandExtension):
    """Hydrostatic rotary drive: run it, compare it with a log, find what its model lacks."""

    def add_arguments(self, parser, cli_name, *, argv=None):
        """Leave all that follows to the verb."""
        parser.usage = f'{cli_name} VERB [ARGUMENTS]'
        parser.formatter_class = argparse.RawDescriptionHelpFormatter
        parser.epilog = f'{overview()}\n\nEach verb explains itself: {cli_name} VERB --help'
        parser.add_argument('arguments', nargs=argparse.REMAINDER, help=argparse.SUPPRESS)

    def main(self, *, parser, args):
        """Hand over and return the exit code."""
        return main(args.arguments, prog='ros2 hst')
