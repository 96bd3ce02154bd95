"""The documentation: MyST pages, the executed notebooks, and the reference from docstrings.  ``make docs`` builds it.

Of the extensions in ``_ext``, ``collect`` brings notebooks and notes and ``pictures`` draws what pages show, both into
folders that git ignores; ``explore`` adds the page in the browser; ``narrow``
makes tables fit a phone; ``lure_docs`` makes the reference from the code it
describes.  The site needs no network: formulas are set by a MathJax that is copied into it.
"""

import sys
from pathlib import Path

import lure

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "lure"
author = "The lure authors"
copyright = author
version = release = lure.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx-mathjax-offline",
    "collect",
    "pictures",
    "explore",
    "narrow",
    "lure_docs",
]
exclude_patterns = ["_ext", "_templates", "notebooks/download"]
highlight_language = "none"  # a block that does not name its language is a formula or a drawing

html_theme = "pydata_sphinx_theme"
html_title = "lure"
html_favicon = "_static/lure.svg"
html_static_path = ["_static"]
templates_path = ["_templates"]
html_css_files = ["site.css"]
html_js_files = ["narrow.js"]
html_show_sourcelink = False
html_copy_source = False
html_search_scorer = str(Path(__file__).parent / "_ext" / "scorer.js")
html_context = {"default_mode": "auto"}  # without it the theme complains in the console of a first visit
html_theme_options = {
    "logo": {"text": "lure", "image_light": "_static/lure.svg", "image_dark": "_static/lure.svg"},
    "header_links_before_dropdown": 9,
    "navbar_align": "left",
    "footer_start": ["copyright"],
    "footer_end": ["lure-version"],
    "show_prev_next": True,
    "show_toc_level": 2,
}
html_sidebars = {"index": [], "tutorial": [], "gallery": [], "coming-from": []}  # their contents stand on the right

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_substitutions = {"version": lure.__version__}
myst_heading_anchors = 3
nb_execution_mode = "off"  # `make docs` takes the notebooks as `make notebooks` has run them
nb_merge_streams = True
nb_code_prompt_show = "Show imports and helpers"  # the cells tagged hide-input
nb_code_prompt_hide = "Hide imports and helpers"
nb_ipywidgets_js = {}  # nothing is fetched; `collect` leaves no sliders

autodoc_typehints = "none"  # the docstrings have them
autodoc_member_order = "bysource"
autosummary_generate = False  # the tables link to the entries on the same page
napoleon_google_docstring = False
napoleon_custom_sections = [("Attributes", "params_style")]  # a list: properties have entries of their own
napoleon_use_rtype = False
copybutton_exclude = ".linenos, .gp, .go"
