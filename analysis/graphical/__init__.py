"""Drawings for people who decide by looking: Popov and Nyquist plots that say what they do not prove."""

from analysis.graphical.nyquist import nyquist_response as nyquist_response
from analysis.graphical.nyquist_result import NyquistResponse as NyquistResponse
from analysis.graphical.popov import popov_response as popov_response
from analysis.graphical.popov_result import PopovResponse as PopovResponse
