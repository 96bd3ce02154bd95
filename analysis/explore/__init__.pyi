from lure.analysis.explore.build import write_page as write_page
from lure.analysis.explore.served import respond as respond
