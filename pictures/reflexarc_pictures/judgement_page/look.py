"""The look of the page: that of the page of a suite, and what this one has beside it."""

from reflexarc_pictures.suite_page.style import style

_OWN = """
h1{overflow-wrap:anywhere}h2{overflow-wrap:anywhere}
.verdict{padding:1px 8px;border-radius:9px;white-space:nowrap;font-size:.92em;
border:1.5px solid currentColor}
.v0{color:var(--c3)}.v1{color:var(--below)}.v2{color:var(--soft);border-style:dashed}
.board tbody th{font-weight:600;overflow-wrap:anywhere;min-width:160px;max-width:340px}
.board tbody th a{color:var(--bar);text-decoration:none}
.board thead th{max-width:110px}.board td{vertical-align:top}.board th{vertical-align:top}
.why{display:block;font-size:12px;color:var(--soft);max-width:300px;overflow-wrap:anywhere;
margin-top:3px}
.plain .words{overflow-wrap:anywhere;min-width:120px;max-width:340px}.other b{color:var(--below)}
.timeline{max-width:980px;margin:12px 0;padding-top:12px}.timeline .wide svg{min-width:620px}
.incident{stroke:var(--ink);stroke-width:1.2}.incident.same{stroke:var(--soft);
stroke-dasharray:2 3}
.f1{color:var(--c1)}.f2{color:var(--c2)}
.flips{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(300px,100%),1fr));gap:14px;
margin:10px 0}
.flip{padding:8px 14px 6px}.flip h4{margin:0;font-size:13.5px}.flip h4 b{font-weight:600}
.flip p{margin:2px 0}.turned{overflow-wrap:anywhere;font-size:13.5px}.flip svg{margin:6px 0}
.frame{fill:none;stroke:var(--rule);stroke-width:1}.bar.pale{fill:var(--thin)}
svg .told{font-size:11px;font-weight:700}
@media(max-width:600px){body{padding:16px 12px 40px}h1{font-size:22px}}
@media print{.flip{break-inside:avoid}}
"""


def look() -> str:
    """The style sheet."""
    return style() + _OWN
