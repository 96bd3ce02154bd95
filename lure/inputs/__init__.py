"""Blocks from whatever a user has: objects of python-control and scipy.signal, matrices, coefficients, text."""

from lure.inputs.coefficients import coefficients as coefficients
from lure.inputs.convert import AnyBlock as AnyBlock
from lure.inputs.convert import as_block as as_block
from lure.inputs.matrices import rational_block as rational_block
from lure.inputs.sampling import sampling_time as sampling_time
from lure.inputs.transfer_text import parse_transfer as parse_transfer
