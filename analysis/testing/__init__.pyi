from lure.analysis.testing.assertions import assert_in_sector as assert_in_sector
from lure.analysis.testing.assertions import assert_monotone as assert_monotone
from lure.analysis.testing.assertions import assert_odd as assert_odd
from lure.analysis.testing.assertions import assert_slope_restricted as assert_slope_restricted
from lure.analysis.testing.result import Checked as Checked
from lure.analysis.testing.result import NonlinearityViolation as NonlinearityViolation
from lure.analysis.testing.result import Violation as Violation
