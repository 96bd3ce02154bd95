"""What the tests of the commands share: a block and a class as options, what is in a folder, and what was written."""

import json

THIRD = ("--num", "1", "--den", "1 3 2 0")  # 1/(s (s + 1)(s + 2)): Routh and Popov reach 6
SECTOR = ("--sector", "0", "5")


def names(directory):
    """Whatever is below a directory, as sorted paths from there."""
    return sorted(path.relative_to(directory).as_posix() for path in directory.rglob("*"))


def written(folder, name="certificate.json"):
    return json.loads((folder / name).read_text("ascii"))
