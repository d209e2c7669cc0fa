/* Pages: head, list of sections, sections. */
#include "report/page.h"

#include "mukca/version.h"

static const char *const mukca_report_style[] = {
    ":root{--ink:#1a1a1a;--paper:#fff;--soft:#f3f4f6;--line:#8a8f98;"
    "--before:#c35200;--after:#0072b2;--grid:#b0b4ba}\n"
    "@media (prefers-color-scheme:dark){:root{--ink:#e8e8e8;--paper:#15181c;--soft:#23272e;"
    "--line:#8a8f98;--before:#ff9a4d;--after:#63b8f0;--grid:#565b63}}\n"
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
    ".figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));"
    "gap:1rem}\n"
    ".pairs{columns:26rem}.pairs .wide{break-inside:avoid}\n"
    "figure{margin:0;min-width:0;overflow-x:auto}\n"
    "figcaption{font-size:.9rem}figcaption strong{display:block}\n"
    ".plot{display:block;width:100%;max-width:30rem;height:auto}"
    ".plot text{paint-order:stroke;stroke:var(--paper);stroke-width:3px;stroke-linejoin:round}\n"
    ".plot text{font:12px sans-serif;fill:var(--ink)}.plot path{fill:none;stroke-width:1.2}"
    ".plot .axis{stroke:var(--ink)}.plot .grid{stroke:var(--grid);stroke-width:.5;"
    "stroke-dasharray:2 3}\n"
    ".plot .before path{stroke:var(--before)}.plot .after path{stroke:var(--after)}"
    ".plot .after circle{fill:var(--after)}.plot .measured path{stroke:var(--line)}\n"
    ".wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;margin:.5rem 0}\n"
    "caption{text-align:left;font-weight:600;padding:.3rem 0}\n"
    "th,td{padding:.2rem .6rem;text-align:left;border-bottom:1px solid var(--grid);vertical-align:"
    "top}td:last-child:not(.n):not(:first-child){min-width:9rem}\n"
    "@media screen and (max-width:40rem){.cards{width:100%}.cards thead{display:none}.cards "
    "tr{display:block;padding:.3rem 0;"
    "border-bottom:1px solid var(--line)}.cards td,.cards td.n{display:flex;gap:.6rem;border:0;"
    "padding:.1rem 0;text-align:left}.cards td:empty{display:none}.cards td::before{content:attr("
    "data-label);flex:0 0 7rem;opacity:.75}}\n",
    "@media screen and "
    "(max-width:40rem){body{padding:.6rem}table{font-size:.75rem;width:100%}th,td{"
    "padding:.15rem .2rem;min-width:0}td:last-child:not(.n):not(:first-child){min-width:0}}\n"
    ".bar{width:30%;min-width:3rem}.bar i{display:block;height:.7rem;margin-top:.3rem;background:"
    "var(--after)}\n"
    ".view{display:block;width:100%;max-width:34rem;max-height:34rem}.view polyline{fill:none;"
    "vector-effect:non-scaling-stroke}.view .arm{stroke:var(--line);stroke-width:3;"
    "stroke-linejoin:round}.view .found{stroke:currentColor;stroke-linecap:round;opacity:.6}"
    ".v0{color:#8a8f98}.v1{color:#009e73}.v2{color:#8f6f00}.v3{color:#cc79a7}.v4{color:#8250df}"
    ".v5{color:#c0152f}.v6{color:#7a9a00}\n"
    ".n{text-align:right;font-variant-numeric:tabular-nums}code{font-size:.85em;overflow-wrap:"
    "anywhere}\n"
    "@media print{:root{--ink:#000;--paper:#fff;--soft:#f3f4f6;--before:#c35200;"
    "--after:#0072b2;--grid:#b0b4ba}body{max-width:none;font-size:10pt;padding:0}"
    "nav{display:none}figure,tr{break-inside:avoid}h2{break-after:avoid;margin-top:1rem}"
    ".wide,figure{overflow:visible}.plot.plot{min-width:0}.figures{grid-template-columns:repeat(4,"
    "1fr)}.view{max-width:60%}table{font-size:7.5pt}th,td{padding:.05rem "
    ".4rem}figcaption{font-size:"
    "7.5pt}.wide{break-inside:avoid}.wide:has(.parameters){columns:2;break-inside:auto}"
    "p,li{orphans:3;widows:3}}\n"};

static void put_head(FILE *out, const mukca_page *p)
{
    fputs(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
        out);
    mukca_html_escape(out, p->robot);
    fprintf(out, ": %s</title>\n<style>\n%s%s</style>\n</head>\n<body>\n<header>\n<h1>", p->kind,
            mukca_report_style[0], mukca_report_style[1]);
    mukca_html_escape(out, p->robot);
    fprintf(out, ": %s</h1>\n<p>From ", p->kind);
    mukca_html_element(out, "code", p->from);
    fputs(" to ", out);
    mukca_html_element(out, "code", p->to);
    fprintf(out, ", mukca %s, %s</p>\n</header>\n<main>\n", MUKCA_VERSION, p->when);
}

void mukca_page_write(FILE *out, const mukca_page *p)
{
    put_head(out, p);
    p->open(out, p->content);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < p->n_sections; k++)
        fprintf(out, "<li><a href=\"#%s\">%s</a></li>\n", p->sections[k].id,
                p->sections[k].heading);
    fputs("</ul></nav>\n", out);
    for (const mukca_page_section *s = p->sections; s < p->sections + p->n_sections; s++) {
        fprintf(out, "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n", s->id, s->id,
                s->heading);
        s->put(out, p->content);
        fputs("</section>\n", out);
    }
    fputs("</main>\n<footer>Made by ", out);
    mukca_html_element(out, "code", p->command);
    fprintf(out, " at %s.</footer>\n</body>\n</html>\n", p->when);
}
