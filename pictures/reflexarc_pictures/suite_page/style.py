"""The style of a page: light and dark, screen and paper; and the few lines that sort its tables.

Line colours are those of Okabe and Ito, which all kinds of colour-blindness tell apart; on paper
without colours dashes tell them apart. Shades of scores are computed: from the ground to one blue
and one orange, so that they also differ in brightness.
"""

import math

from reflexarc_pictures.suite_page.tables import SHADES

Colour = tuple[int, int, int]

_LIGHT: tuple[Colour, Colour, Colour] = (246, 246, 244), (8, 81, 156), (166, 54, 3)
"""Score 0, score 1, score −1."""
_DARK: tuple[Colour, Colour, Colour] = (40, 44, 48), (120, 184, 245), (240, 140, 70)
_BLACK, _WHITE = "#000000", "#ffffff"
_FLARE = 0.05
"""Light that a screen reflects, in WCAG's contrast."""

_LINES = """
--ink:#1c2329;--soft:#5b6670;--ground:#ffffff;--card:#f7f7f5;--rule:#d9dcdf;--grid:#e8eaec;
--bar:#0072b2;--below:#d55e00;--thin:#b6bcc2;
--c1:#0072b2;--c2:#d55e00;--c3:#009e73;--c4:#b0529a;--c5:#a87800;--c6:#2f9bd6;
"""
_LINES_DARK = """
--ink:#e6e9ec;--soft:#a3adb6;--ground:#15181b;--card:#1d2125;--rule:#394047;--grid:#2a2f34;
--bar:#4da3dd;--below:#f08c46;--thin:#5d666e;
--c1:#4da3dd;--c2:#f08c46;--c3:#35c49a;--c4:#dd8bc8;--c5:#e6b422;--c6:#9bd3f5;
"""
_RULES = """
*{box-sizing:border-box}
body{margin:0 auto;max-width:1320px;padding:28px 28px 60px;background:var(--ground);
color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
h1{font-size:30px;line-height:1.2;margin:0 0 4px}h2{font-size:21px;margin:44px 0 12px;
border-bottom:1px solid var(--rule);padding-bottom:5px}
h3{font-size:15px;margin:14px 0 6px;overflow-wrap:anywhere}
p{margin:8px 0;max-width:86ch}.lead{font-size:17px}.note{color:var(--soft);font-size:13.5px}
nav{margin:14px 0 0;font-size:14px}nav a{color:var(--bar);margin-right:16px;white-space:nowrap}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:13.5px;font-variant-numeric:tabular-nums}
th,td{padding:5px 9px;text-align:left;vertical-align:middle}
thead th{color:var(--soft);font-weight:600;font-size:12.5px;vertical-align:bottom;
border-bottom:1px solid var(--rule)}
tbody th{font-weight:600;overflow-wrap:break-word;min-width:150px;max-width:260px}
th .place{color:var(--soft);font-weight:400;margin-right:5px}
.board{width:100%}.board tbody tr{border-bottom:1px solid var(--grid)}
.board thead th{cursor:pointer}.board .place{color:var(--soft);text-align:right}
.num{text-align:right;white-space:nowrap}.words{font-size:12.5px;max-width:190px}
.score b{display:inline-block;min-width:52px;font-size:15px}.score svg{width:110px;
vertical-align:-3px}.score i{display:block}i{font-style:normal;font-size:11.5px;
color:var(--soft);white-space:nowrap}
.heat-table td{border:2px solid var(--ground);text-align:center;min-width:62px;padding:5px 1px}
.heat-table i{display:block;color:inherit;font-size:10px;letter-spacing:-.02em}
.heat-table thead th{text-align:center;border:0}.heat-table thead th:first-child{text-align:left}
.heat-table tbody th{max-width:170px;overflow-wrap:anywhere}
.heat-table td.none{color:var(--soft)}.key{margin:10px 0}.key th{font-weight:400;font-size:12px}
.key td{min-width:48px}.small{font-size:12.5px}.small tbody th{min-width:96px;max-width:150px;
font-weight:500}.small td{min-width:66px}
.plain td,.plain th{vertical-align:top;border-bottom:1px solid var(--grid)}
.agents td{max-width:230px;overflow-wrap:anywhere}.fine{font-size:11.5px;color:var(--soft)}
.cards{display:flex;flex-wrap:wrap;gap:16px;align-items:flex-start;margin:12px 0}
.card{background:var(--card);border-radius:8px;padding:4px 14px 12px;flex:1 1 auto;
min-width:0;max-width:100%}.panel{flex:0 1 280px}
.two{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(520px,100%),1fr));gap:16px;
margin:12px 0}
.card .heat-table td{border-color:var(--card)}
pre,.command{background:var(--card);padding:10px 12px;border-radius:6px;font-size:12.5px;
white-space:pre-wrap;overflow-wrap:anywhere;margin:8px 0}.card pre{background:var(--ground)}
details summary{cursor:pointer;color:var(--bar);margin:10px 0}
svg{width:100%;height:auto;display:block;font-size:12px;overflow:visible}
svg text{fill:var(--ink)}.legend svg{display:inline-block;width:28px;vertical-align:middle}
.legend span{margin-right:18px;white-space:nowrap;font-size:13px}
.score svg{display:inline-block}
.end{text-anchor:end}.middle{text-anchor:middle}svg .tick,svg .name{fill:var(--soft)}
.tick{font-size:11px}.grid{stroke:var(--grid);stroke-width:1}.axis{stroke:var(--soft);
stroke-width:1}.line{fill:none;stroke-width:2;stroke-linejoin:round}
.leader{fill:none;stroke-width:1;opacity:.6}.bar{fill:var(--bar)}.bar.below{fill:var(--below)}
.whisker{stroke:var(--ink);stroke-width:1.6}.stem{stroke:var(--thin);stroke-width:2}
.critical{fill:var(--below);opacity:.10}
.line.blind{stroke:var(--soft);stroke-dasharray:1.5 4;stroke-linecap:round}
.line.oracle{stroke:var(--soft);stroke-dasharray:7 4}
.line.c0{stroke:var(--thin);stroke-width:1.1}.dot{stroke:var(--ground);stroke-width:1.2}
.dot.c0{fill:var(--thin)}
.c2.line{stroke-dasharray:8 3}.c3.line{stroke-dasharray:3 2.5}.c4.line{stroke-dasharray:9 3 2 3}
.c5.line{stroke-dasharray:5 4}.c6.line{stroke-dasharray:12 3 2 3 2 3}
@media print{body{max-width:none;padding:0;font-size:11px}nav{display:none}
*{print-color-adjust:exact;-webkit-print-color-adjust:exact}
.wide{overflow:visible}h2{break-after:avoid}.card,tr,svg{break-inside:avoid}}
"""

SORTING = """
document.querySelectorAll('#board thead th').forEach(function(head,k){
head.onclick=function(){var body=document.querySelector('#board tbody');
var key=function(tr){var c=tr.children[k],v=c.dataset.v;
return v===undefined?c.textContent:v===''?-1e9:+v};
var rows=Array.from(body.children),down=head.dataset.down!=='1';head.dataset.down=down?'1':'';
rows.sort(function(a,b){var x=key(a),y=key(b);return(x<y?-1:x>y?1:0)*(down?-1:1)});
rows.forEach(function(tr){body.appendChild(tr)})}})
"""
"""Sorts the leaderboard by a column; without it everything can be read all the same."""


def style() -> str:
    """The style sheet."""
    lines = "".join(
        f".c{k}{{--own:var(--c{k})}}.line.c{k},.leader.c{k}{{stroke:var(--c{k})}}"
        f".dot.c{k},text.c{k}{{fill:var(--c{k})}}"
        for k in range(1, 7)
    )
    dark = f":root{{color-scheme:dark;{_LINES_DARK}}}{_shades(*_DARK)}"
    return (
        f":root{{color-scheme:light;{_LINES}}}{_RULES}{lines}{_shades(*_LIGHT)}"
        f"@media screen and (prefers-color-scheme:dark){{{dark}}}"
    )


def _shades(zero: Colour, best: Colour, worst: Colour) -> str:
    rules = []
    for letter, end in (("h", best), ("m", worst)):
        for k in range(SHADES + 1):
            colour = _between(zero, end, (k / SHADES) ** 1.2)
            rules.append(
                f".{letter}{k}{{background:rgb{colour};color:{_ink_on(colour)}}}".replace(" ", "")
            )
    return "".join(rules)


def _between(start: Colour, end: Colour, share: float) -> Colour:
    red, green, blue = (round(a + share * (b - a)) for a, b in zip(start, end, strict=True))
    return red, green, blue


def _ink_on(ground: Colour) -> str:
    """Black or white, whichever is told better from a ground."""
    light = _luminance(ground) + _FLARE
    return _BLACK if light / _FLARE > (1.0 + _FLARE) / light else _WHITE


def _luminance(colour: Colour) -> float:
    """Relative luminance (WCAG 2.1)."""
    red, green, blue = (_linear(part / 255.0) for part in colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _linear(part: float) -> float:
    return part / 12.92 if part <= 0.04045 else math.pow((part + 0.055) / 1.055, 2.4)
