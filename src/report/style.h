/* The report's style sheet: light and dark schemes, screen, phone and paper. */
#ifndef MUKCA_REPORT_STYLE_H
#define MUKCA_REPORT_STYLE_H

/* The figures have the light colours as attributes; rules for the value of an attribute replace
 * each by that of the scheme in use.  (gnuplot writes a colour as rgb with padded numbers.) */
#define REPORT_COLOUR(value, variable)                    \
    ".plot [stroke=\"" value "\"]{stroke:var(--" variable \
    ")}"                                                  \
    ".plot [fill=\"" value "\"]{fill:var(--" variable     \
    ")}"                                                  \
    ".plot [color=\"" value "\"]{color:var(--" variable ")}\n"

static const char mukca_report_style[] =
    ":root{--ink:#1a1a1a;--paper:#fff;--soft:#f3f4f6;--line:#8a8f98;"
    "--before:#c35200;--after:#0072b2;--third:#007a58;--grid:#b0b4ba}\n"
    "@media (prefers-color-scheme:dark){:root{--ink:#e8e8e8;--paper:#15181c;--soft:#23272e;"
    "--line:#8a8f98;--before:#ff9a4d;--after:#63b8f0;--third:#3ecfa0;--grid:#565b63}}\n"
    "*{box-sizing:border-box}\n"
    "body{margin:0 auto;padding:1rem;max-width:62rem;font:16px/1.5 system-ui,sans-serif;"
    "color:var(--ink);background:var(--paper)}\n"
    "h1{font-size:1.6rem;line-height:1.2;margin:.2em 0}h2{font-size:1.2rem;margin:2rem 0 .5rem;"
    "border-bottom:1px solid var(--line)}\n"
    "nav ul{display:flex;flex-wrap:wrap;gap:.2rem 1rem;padding:0;list-style:none}\n"
    "a{color:var(--after)}\n"
    ".verdict{padding:.7rem 1rem;background:var(--soft);border-left:.4rem solid var(--after);"
    "font-size:1.1rem}\n"
    ".verdict.unknown,.verdict.tied,.verdict.untestable{border-color:var(--before)}\n"
    ".tiles{display:grid;grid-template-columns:repeat(auto-fill,minmax(9.5rem,1fr));gap:.6rem;"
    "margin:1rem 0}\n"
    ".tiles div{background:var(--soft);padding:.5rem .7rem}.tiles dt{font-size:.85rem}\n"
    ".tiles dd{margin:0;font-size:1.4rem;font-variant-numeric:tabular-nums}.tiles small{font-size:"
    ".8rem}\n"
    ".figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));"
    "gap:1rem}\n"
    "figure{margin:0;min-width:0;overflow-x:auto}figure.broad{grid-column:1/-1}\n"
    "figcaption{font-size:.9rem}figcaption strong{display:block}\n"
    ".plot{display:block;width:100%;max-width:30rem;height:auto}"
    ".plot text{paint-order:stroke;stroke:var(--paper);stroke-width:3px;stroke-linejoin:round}\n"
    ".broad .plot{min-width:40rem;max-width:none}\n"
    REPORT_COLOUR("black", "ink") REPORT_COLOUR("rgb(  0,   0,   0)", "ink")
    REPORT_COLOUR("gray", "grid") REPORT_COLOUR("rgb(190, 190, 190)", "grid")
    REPORT_COLOUR("white", "paper") REPORT_COLOUR("rgb(213,  94,   0)", "before")
    REPORT_COLOUR("rgb(  0, 114, 178)", "after") REPORT_COLOUR("rgb(  0, 158, 115)", "third")
    ".wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;margin:.5rem 0}\n"
    "caption{text-align:left;font-weight:600;padding:.3rem 0}\n"
    "th,td{padding:.2rem .6rem;text-align:left;border-bottom:1px solid var(--grid);vertical-align:"
    "top}th{min-width:4.5rem}td:last-child:not(.n):not(:first-child){min-width:9rem}\n"
    "@media screen and (max-width:40rem){.cards{width:100%}.cards thead{display:none}.cards tr{display:block;padding:.3rem 0;"
    "border-bottom:1px solid var(--line)}.cards td,.cards td.n{display:flex;gap:.6rem;border:0;"
    "padding:.1rem 0;text-align:left}.cards td:empty{display:none}.cards td::before{content:attr("
    "data-label);flex:0 0 7rem;opacity:.75}}\n"
    ".matrix th,.matrix td{min-width:0;padding:.2rem .35rem}.matrix th{font-weight:400}.matrix td{"
    "background:color-mix(in srgb,var(--before) var(--share,0%),transparent)}\n"
    ".n{text-align:right;font-variant-numeric:tabular-nums}code{font-size:.85em;overflow-wrap:"
    "anywhere}\n"
    "@media print{:root{--ink:#000;--paper:#fff;--soft:#f3f4f6;--before:#c35200;"
    "--after:#0072b2;--third:#007a58;--grid:#b0b4ba}body{max-width:none;font-size:10pt;padding:0}"
    "nav{display:none}figure,tr,.tiles{break-inside:avoid}h2{break-after:avoid}"
    ".wide,figure{overflow:visible}.plot.plot{min-width:0}}\n";

#endif
