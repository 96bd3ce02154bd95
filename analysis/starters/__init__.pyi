from lure.analysis.starters.files import law_test as law_test
from lure.analysis.starters.files import notebook_script as notebook_script
from lure.analysis.starters.notebook import notebook_json as notebook_json
