from lure.analysis.graphical.nyquist import NyquistResponse as NyquistResponse
from lure.analysis.graphical.nyquist import nyquist_response as nyquist_response
from lure.analysis.graphical.popov import PopovResponse as PopovResponse
from lure.analysis.graphical.popov import popov_response as popov_response
