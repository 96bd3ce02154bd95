"""The documentation: MyST pages, the executed notebooks, and the reference from docstrings.  ``make docs`` builds it."""

import lure

project = "lure"
author = "The lure authors"
copyright = author  # noqa: A001
version = release = lure.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx-mathjax-offline",
]
exclude_patterns = ["_build"]
html_theme = "pydata_sphinx_theme"
html_title = "lure"

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # `make docs` takes the notebooks as `make notebooks` has run them

autodoc_typehints = "none"  # the docstrings have them
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
copybutton_exclude = ".linenos, .gp, .go"
