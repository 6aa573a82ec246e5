"""Sphinx's configuration of the site; build.py copies it beside the pages."""

import warnings

warnings.filterwarnings("ignore", category=DeprecationWarning)
project = "SlipStep"
copyright = "the authors of SlipStep"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 4
myst_enable_extensions = []
html_theme = "sphinx_rtd_theme"
html_theme_options = {"navigation_depth": 3, "collapse_navigation": True}
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
suppress_warnings = ["myst.header"]  # functions begin at the second level
highlight_language = "none"
