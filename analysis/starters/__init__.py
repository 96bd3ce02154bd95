"""Files to start from: a notebook about one's own loop, and a test that guards one's own law."""

from analysis.starters.files import law_test as law_test
from analysis.starters.files import notebook_script as notebook_script
from analysis.starters.notebook import notebook_json as notebook_json
