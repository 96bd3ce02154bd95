from lure.analysis.starters.files import nonlinearity_test as nonlinearity_test
from lure.analysis.starters.files import notebook_json as notebook_json
from lure.analysis.starters.files import notebook_script as notebook_script
