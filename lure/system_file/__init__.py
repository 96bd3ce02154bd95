"""Systems as TOML files: read with every number exact, checked, changed from the command line, and written back."""

from lure.system_file.plant_writing import loop_to_toml as loop_to_toml
from lure.system_file.plant_writing import plant_template as plant_template
from lure.system_file.reading import find_system as find_system
from lure.system_file.reading import parse_system as parse_system
from lure.system_file.reading import read_system as read_system
from lure.system_file.writing import system_to_toml as system_to_toml
from lure.system_file.writing import template as template
