from lure.files.loop import loop_to_toml as loop_to_toml
from lure.files.loop import plant_template as plant_template
from lure.files.reading import find_system as find_system
from lure.files.reading import parse_system as parse_system
from lure.files.reading import read_system as read_system
