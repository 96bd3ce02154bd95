from lure.plants.conversion import AnyBlock as AnyBlock
from lure.plants.conversion import as_plant as as_plant
from lure.plants.matrices import rational_block as rational_block
from lure.plants.text import coefficients as coefficients
from lure.plants.text import parse_transfer as parse_transfer
from lure.plants.text import sampling_time as sampling_time
