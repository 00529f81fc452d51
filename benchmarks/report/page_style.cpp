#include "benchmarks/report/page_parts.hpp"

namespace finegauge {

// Colours of curves: Okabe & Ito 2008, "Color universal design", in the order of benchmarks/program/plots.cpp,
// lightened for dark pages; the last is text's. Curves are told apart by dashes, too.
const char* const page_style = R"css(:root {
  --page: #ffffff; --card: #f7f8f9; --text: #1d2329; --soft: #5a646e; --rule: #d9dee3; --grid: #e6e9ec;
  --good: #0b6b4f; --bad: #b3261e; --bad-back: #fdeceb; --good-back: #e9f5f0; --link: #0b5cad;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #b8568f; --c4: #3f9fd6; --c5: #b97a00; --c6: #5a646e;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --page: #14181c; --card: #1c2127; --text: #e4e8ec; --soft: #a0abb5; --rule: #37404a; --grid: #2a3138;
    --good: #5ccba6; --bad: #ff8f86; --bad-back: #3a1f1e; --good-back: #17302a; --link: #7fb8f2;
    --c0: #56a8e6; --c1: #f08a3c; --c2: #2fc79a; --c3: #e29ac3; --c4: #8fd0f5; --c5: #f0b93f; --c6: #a0abb5;
  }
}
* { box-sizing: border-box; }
html { scroll-padding-top: 3.5rem; }
body { margin: 0; background: var(--page); color: var(--text); font: 16px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", "DejaVu Sans", Arial, sans-serif;
  font-variant-numeric: tabular-nums; -webkit-text-size-adjust: 100%; }
header, nav, main, footer { max-width: 1320px; margin: 0 auto; padding: 0 20px; }
h1 { font-size: 1.7rem; margin: 1.4rem 0 .4rem; letter-spacing: -.01em; }
h2 { font-size: 1.4rem; margin: 2.6rem 0 .3rem; padding-bottom: .25rem; border-bottom: 2px solid var(--rule); }
h3 { font-size: 1.12rem; margin: 1.9rem 0 .2rem; }
h4 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
small { font-weight: 400; font-size: .85em; color: var(--soft); }
p { margin: .4rem 0 .8rem; max-width: 76ch; }
a { color: var(--link); text-decoration-thickness: 1px; text-underline-offset: 2px; }
code { font: .86em ui-monospace, "SFMono-Regular", Menlo, Consolas, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
nav { display: flex; flex-wrap: wrap; gap: .25rem 1.1rem; padding-top: .5rem; padding-bottom: .5rem; }
.lead { color: var(--soft); }
.aside { color: var(--soft); font-size: .88rem; max-width: none; overflow-wrap: anywhere; }
.good { color: var(--good); } .fail { color: var(--bad); font-weight: 600; }
.tag { border: 1px solid var(--rule); border-radius: 3px; padding: 0 .35em; font-size: .8em; color: var(--soft); }
.verdict { border-left: 5px solid var(--good); background: var(--good-back); padding: .6rem 1rem; margin: 1rem 0; border-radius: 0 6px 6px 0; }
.verdict.no { border-color: var(--bad); background: var(--bad-back); }
.verdict p { margin: .2rem 0; font-size: 1.15rem; }
.scroll { overflow-x: auto; margin: .6rem 0 1rem; }
table { border-collapse: collapse; font-size: .88rem; line-height: 1.4; }
th, td { text-align: left; vertical-align: top; padding: .3rem .9rem .3rem 0; border-bottom: 1px solid var(--rule); overflow-wrap: break-word; max-width: 34rem; }
th { font-weight: 600; color: var(--soft); vertical-align: bottom; border-bottom: 1.5px solid var(--soft); }
th.n, td.n { text-align: right; white-space: nowrap; }
tr.bad td { background: var(--bad-back); }
.unit { font-weight: 400; white-space: nowrap; }
details { margin: .4rem 0; border: 1px solid var(--rule); border-radius: 6px; padding: 0 .8rem; }
summary { cursor: pointer; padding: .45rem 0; font-size: .92rem; }
.facts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 11.5rem), 1fr)); gap: .55rem 1.2rem; margin: .7rem 0 1.1rem; }
.facts div { border-top: 1px solid var(--rule); padding-top: .25rem; min-width: 0; }
dt { font-size: .8rem; color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 30rem), 1fr)); gap: 1.1rem 1.6rem; margin: .8rem 0 1.2rem; align-items: start; }
figure { margin: 0 0 .6rem; padding: .8rem; background: var(--card); border-radius: 8px; min-width: 0; max-width: 44rem; }
figure.wide { grid-column: 1 / -1; max-width: 64rem; }
figcaption { font-size: .84rem; line-height: 1.45; color: var(--soft); margin-top: .45rem; }
figcaption b:first-child { color: var(--text); }
.by { display: block; margin-top: .15rem; }
.paper { background: #fff; border-radius: 4px; overflow: hidden; }
svg { display: block; width: 100%; height: auto; }
.spark { width: 120px; min-width: 120px; height: 26px; }
.legend { display: flex; flex-wrap: wrap; gap: .1rem 1rem; font-size: .84rem; margin-bottom: .2rem; }
.key { display: inline-flex; align-items: center; gap: .4rem; }
.key i { display: inline-block; width: 1.5rem; height: 0; border-top: 2.4px solid; flex: none; }
.key i.swatch { height: .7rem; width: .9rem; border: 0; background: currentColor; }
.key i.band { opacity: .3; }
.key i.point { width: .6rem; height: .6rem; border: 0; border-radius: 50%; background: currentColor; }
.c0 { color: var(--c0); } .c1 { color: var(--c1); } .c2 { color: var(--c2); } .c3 { color: var(--c3); } .c4 { color: var(--c4); } .c5 { color: var(--c5); } .c6 { color: var(--c6); }
.key i.c1 { border-top-style: dashed; } .key i.c2 { border-top-style: dotted; } .key i.c3 { border-top-style: dashed; } .key i.c4 { border-top-style: dotted; }
.chart text { font-size: 13px; fill: var(--text); font-family: inherit; }
.chart .tick { fill: var(--soft); font-size: 12.5px; }
.chart .name { fill: var(--text); }
.chart .note { font-size: 12.5px; fill: var(--text); paint-order: stroke; stroke: var(--card); stroke-width: 4px; stroke-linejoin: round; }
.chart .row { font-weight: 500; } .chart .bad { fill: var(--bad); }
.mid { text-anchor: middle; } .end { text-anchor: end; }
.grid path { stroke: var(--grid); fill: none; }
.axis { stroke: var(--soft); fill: none; }
.rule { stroke: var(--text); stroke-dasharray: 5 4; fill: none; stroke-width: 1.2; }
.track { stroke: var(--rule); stroke-width: 6; stroke-linecap: round; fill: none; }
.cross { stroke: var(--bad); stroke-width: 3; fill: none; }
.line { fill: none; stroke: currentColor; stroke-width: 1.8; stroke-linejoin: round; }
.c1 > .line { stroke-dasharray: 7 3; } .c2 > .line { stroke-dasharray: 2.5 2; } .c3 > .line { stroke-dasharray: 9 3 2 3; } .c4 > .line { stroke-dasharray: 4 2 1 2; }
.dot { fill: currentColor; stroke: var(--card); stroke-width: 1; }
.band { fill: currentColor; opacity: .22; }
.bars rect { fill: currentColor; opacity: .8; } .bar { fill: currentColor; }
#tip { position: absolute; z-index: 9; pointer-events: none; background: var(--text); color: var(--page); font-size: .8rem; line-height: 1.35; padding: .3rem .55rem; border-radius: 4px; max-width: 18rem; white-space: pre-line; }
#tip[hidden] { display: none; }
.cross-hair { stroke: var(--soft); fill: none; pointer-events: none; } .spot { fill: none; stroke: var(--text); stroke-width: 1.6; pointer-events: none; }
footer { color: var(--soft); font-size: .84rem; padding-top: 2rem; padding-bottom: 2rem; }
@media (min-width: 821px) { nav { position: sticky; top: 0; background: var(--page); z-index: 5; } }
@media (max-width: 560px) {
  header, nav, main, footer { padding-left: 12px; padding-right: 12px; }
  figure { padding: .6rem .4rem; }
  .chart text, .chart .tick, .chart .note { font-size: 17px; }
  th, td { max-width: 15rem; }
  td { min-width: 4rem; }
}
@media print {
  :root { --page: #fff; --card: #fff; --text: #000; --soft: #444; --rule: #bbb; --grid: #ddd; --bad-back: #fff; --good-back: #fff; }
  @page { margin: 14mm; }
  body { font-size: 10pt; }
  header, main, footer { max-width: none; padding: 0; }
  nav { display: none; }
  .figures { grid-template-columns: 1fr 1fr; gap: 6mm; }
  figure, tr, h2, h3, h4 { break-inside: avoid; } h2, h3, h4 { break-after: avoid; }
  figure { padding: 0; } .facts { grid-template-columns: repeat(4, 1fr); gap: 1.5mm 5mm; } dd { font-size: 9pt; }
  .scroll { overflow: visible; } table { font-size: 7.5pt; } th, td { padding-right: 2.5mm; max-width: 60mm; overflow-wrap: anywhere; }
  th.n, td.n { white-space: normal; overflow-wrap: normal; }
  details:not([open]) { border: 0; padding: 0; } a { color: inherit; text-decoration: none; }
}
)css";

}  // namespace finegauge
