from lure.analysis.cli.__main__ import main as main
