"""What the tests of system files share: the paper's rod as a file, read as it is or with one line changed."""

import re

from refusals import refusal

from lure.files import parse_system

ROD = """
[rod]
youngs_modulus = 288e6
density = 8
length = 1
area = 0.25e-4
damping = 2e-4
compliance = 1
"""


def parsed(text, *settings):
    return parse_system(text, name="rod", source="rod.toml", settings=settings)


def with_line(line, table="rod"):
    """The smallest file with one line in one table, in the place of the line for the same key if there is one."""
    key = re.escape(line.split("=")[0].strip())
    text = re.sub(rf"^{key} *=.*\n", "", ROD, flags=re.MULTILINE) if table == "rod" else ROD
    return text + (f"{line}\n" if table == "rod" else f"[{table}]\n{line}\n")


def refused(text, *settings):
    return refusal(parsed, text, *settings)
