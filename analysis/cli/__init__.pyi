from lure.analysis.cli.entry import main as main
