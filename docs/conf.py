"""Settings of the documentation site, which `make site` builds with Sphinx."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from docutils.nodes import SkipNode, math_block
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

import rtcli

if TYPE_CHECKING:
    from docutils.nodes import Element, math
    from sphinx.addnodes import pending_xref
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment
    from sphinx.writers.html5 import HTML5Translator

project = "rtcli"
version = release = rtcli.__version__
author = "The rtcli authors"
copyright = author

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
highlight_language = "none"

# Equations are LaTeX, as GitHub shows it: `$...$` in a line, and blocks of the language `math`. They become MathML
# when the site is built. MathJax would come from a CDN, or add megabytes.
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
html_math_renderer = "mathml"

# Anchors as GitHub makes them, down to this level, so that links to sections work there and here.
myst_heading_anchors = 4

# Public docstrings are numpydoc. Signatures have the types; the text describes arrays by shape and dtype.
napoleon_google_docstring = False
napoleon_attr_annotations = False
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
default_role = "code"
add_module_names = False

# Every reference must lead somewhere, except to names of other packages, whose inventories are on the network, and
# to names below `rtcli.NAME`, which are not public.
nitpicky = True
nitpick_ignore_regex = [("py:.*", r"(?!rtcli\.\w+$).*")]

html_theme = "furo"
html_title = f"rtcli {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent

# Pages whose text stands elsewhere in the repository, where people look for it.
ELSEWHERE = {
    "changelog": "CHANGELOG.md",
    "contributing": "CONTRIBUTING.md",
    "explanation/native-tracer": "tracer/README.md",
    "explanation/benchmarks": "benchmarks/README.md",
    "security": "SECURITY.md",
}

# Where the repository can be browsed, such as https://github.com/OWNER/NAME/blob/COMMIT. Without it, links to its
# files are downloads, and links to its folders are only text.
SOURCE_URL = os.environ.get("RTCLI_SOURCE_URL", "").rstrip("/")

_LINK = re.compile(r"(?P<image>!?)\[(?P<text>[^]]*)\]\((?P<path>(?![a-z]+:|#)[^)#\s]+)(?P<anchor>#[^)\s]*)?\)")


def show_page(app: Sphinx, docname: str, content: list[str]) -> None:
    """Fill in the text of a page that stands elsewhere, and redirect links that lead out of this folder."""
    page = ROOT / ELSEWHERE[docname] if docname in ELSEWHERE else Path(app.env.doc2path(docname))
    text = page.read_text(encoding="utf-8") if docname in ELSEWHERE else content[0]
    here = (DOCS / docname).parent

    def redirected(link: re.Match[str]) -> str:
        target = (page.parent / link["path"]).resolve()
        if link["image"] or not target.is_relative_to(ROOT) or not target.exists():
            return link[0]
        path = target.relative_to(ROOT).as_posix()
        for name, elsewhere in ELSEWHERE.items():
            if path == elsewhere:
                target = DOCS / f"{name}.md"
        if not target.is_relative_to(DOCS):
            if SOURCE_URL:
                return f"[{link['text']}]({SOURCE_URL}/{path}{link['anchor'] or ''})"
            if target.is_dir():
                return link["text"]
        return f"[{link['text']}]({os.path.relpath(target, here)}{link['anchor'] or ''})"

    content[0] = _LINK.sub(redirected, text)


def find_public_name(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: Element) -> Any:
    """Resolve the name of a class in the module that defines it to its public name, which is documented."""
    name = node["reftarget"].rpartition(".")[2]
    if node["refdomain"] != "py" or name not in rtcli.__all__:
        return None
    domain = env.domains["py"]
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"rtcli.{name}", node, content)


def write_equation(translator: HTML5Translator, node: math | math_block) -> None:
    """Write an equation as MathML; one that docutils cannot read is a warning."""
    is_block = isinstance(node, math_block)
    try:
        mathml = tex2mathml(node.astext(), as_block=is_block)
    except MathError as error:
        logging.getLogger(__name__).warning("%s", error, location=node)
    else:
        # Browsers take a bar for an operator, with space around it.
        mathml = mathml.replace('<mo stretchy="false">|', '<mo stretchy="false" lspace="0" rspace="0">|')
        translator.body.append(f'<div class="equation">{mathml}</div>' if is_block else mathml)
    raise SkipNode


def setup(app: Sphinx) -> None:
    """Connect the functions above to the build."""
    app.add_html_math_renderer("mathml", (write_equation, None), (write_equation, None))
    app.connect("source-read", show_page)
    app.connect("missing-reference", find_public_name)
