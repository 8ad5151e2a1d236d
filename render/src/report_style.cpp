#include "report_parts.hpp"

namespace fricid::render {

Html report_style() {
  return Html(Vouched{R"CSS(
:root {
  color-scheme: light dark;
  --paper: #fff; --ink: #1b1b1b; --soft: #5d6066; --rule: #c9c9c9; --grid: #dddddd;
  --shade: #f5f5f2; --link: #1f5a96; --alert: #a33a00;
  --serif: Charter, "Bitstream Charter", "Sitka Text", Cambria, Georgia, serif;
  --sans: "Helvetica Neue", Helvetica, Arial, "DejaVu Sans", sans-serif;
  --mono: ui-monospace, "SF Mono", Menlo, Consolas, "DejaVu Sans Mono", monospace;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #16181b; --ink: #e3e1db; --soft: #9fa3a8; --rule: #45484d; --grid: #34373c;
    --shade: #1f2226; --link: #8ab8ea; --alert: #f0965a;
  }
}
* { box-sizing: border-box; }
html { font-size: 17px; -webkit-text-size-adjust: 100%; }
body {
  margin: 0 auto; padding: 2.5rem 1.25rem 5rem; max-width: 52rem;
  background: var(--paper); color: var(--ink); font-family: var(--serif); line-height: 1.5;
  overflow-wrap: break-word;
}
h1, h2, h3, h4 { font-weight: 600; line-height: 1.25; }
h1 { font-size: 1.75rem; margin: 0 0 .25rem; }
h2 { font-size: 1.3rem; margin: 3.2rem 0 .8rem; padding-top: .7rem; border-top: 1px solid var(--rule); }
h3 { font-size: 1.05rem; margin: 2.2rem 0 .6rem; }
h4 { font-size: .95rem; margin: 1.5rem 0 .4rem; font-style: italic; }
p { margin: .6rem 0; }
a { color: var(--link); text-decoration-thickness: 1px; text-underline-offset: .15em; }
.byline, .note, figcaption, .caption, nav { color: var(--soft); font-size: .84rem; }
.byline { margin-bottom: 1.6rem; }
.abstract { font-size: 1.06rem; margin: 1.4rem 0; }
nav { margin: 1.4rem 0 0; line-height: 1.9; }
nav a { margin-right: 1.1em; white-space: nowrap; }
code, pre { font-family: var(--mono); font-size: .8rem; }
pre { background: var(--shade); padding: .8rem 1rem; overflow-x: auto; line-height: 1.4; }
.scroll { overflow-x: auto; margin: 1.2rem 0 1.2rem 50%; transform: translateX(-50%);
  width: max-content; min-width: 100%; max-width: max(100%, min(100vw - 3.5rem, 76rem)); }
table { border-collapse: collapse; font-size: .84rem; font-variant-numeric: tabular-nums lining-nums;
  border-top: 1.5px solid var(--ink); border-bottom: 1.5px solid var(--ink); min-width: 60%; }
.caption { margin: 1.4rem 0 .5rem; }
.caption + .scroll { margin-top: 0; }
.caption b { color: var(--ink); font-weight: 600; }
th, td { padding: .22rem .42rem; text-align: right; white-space: nowrap; vertical-align: baseline; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
thead th { border-bottom: 1px solid var(--rule); font-weight: 600; vertical-align: bottom; }
tbody th { font-weight: 400; }
td.text, th.text { text-align: left; white-space: normal; min-width: 12rem; }
sup { font-size: .72em; line-height: 0; }
td.best { font-weight: 700; }
td.bad, th.bad { color: var(--alert); }
tr.rule > * { border-top: 1px solid var(--rule); }
tr.soft > *, td.soft, .soft { color: var(--soft); }
.dot { display: inline-block; width: .62em; height: .62em; border-radius: 50%; margin-right: .5em; }
.dot.ring { background: none !important; border: 1.5px solid var(--ink); }
figure { margin: 2rem 0; break-inside: avoid; }
figcaption { margin-top: .5rem; }
figcaption b { color: var(--ink); font-weight: 600; }
.files a { color: inherit; }
.plot { overflow-x: auto; }
.plot label { display: block; cursor: zoom-in; }
.plot svg { display: block; width: 100%; max-width: calc(var(--width) * 1.2);
  min-width: min(var(--width), 40rem); height: auto; margin: 0 auto; }
.plot text { font-family: var(--sans); }
.gridline { stroke: var(--grid); }
.zoom { position: absolute; opacity: 0; width: 1px; height: 1px; }
.zoom:focus-visible + .plot { outline: 2px solid var(--link); outline-offset: 3px; }
.zoom:checked + .plot label { cursor: zoom-out; }
.zoom:checked + .plot svg { width: calc(var(--width) * 2.4); max-width: none; min-width: 0; }
.symbols { position: absolute; }
video { width: 100%; background: #000; }
details { margin: .8rem 0; }
summary { cursor: pointer; color: var(--link); font-size: .9rem; }
dl { margin: .8rem 0; display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.2rem;
  font-size: .9rem; }
dt { color: var(--soft); }
dd { margin: 0; min-width: 0; }
.warning { border-left: 2px solid var(--alert); padding-left: .9rem; margin: 1rem 0; }
.warning p { margin: .15rem 0; }
@media (max-width: 40rem) {
  html { font-size: 16px; }
  body { padding: 1.2rem .9rem 3rem; }
  dl { grid-template-columns: 1fr; gap: 0; }
  dd { margin-bottom: .4rem; }
}
@media print {
  :root { --paper: #fff; --ink: #000; --soft: #444; --rule: #999; --grid: #dddddd; --link: #000;
    color-scheme: light; }
  html { font-size: 9.5pt; }
  body { max-width: none; padding: 0; }
  nav, .files, video, .zoom { display: none; }
  a { text-decoration: none; }
  details::details-content { content-visibility: visible; block-size: auto; }
  .scroll, .plot, pre { overflow: visible; }
  .scroll { margin-left: 0; transform: none; width: auto; }
  pre { white-space: pre-wrap; }
  .plot svg { min-width: 0; }
  h2, h3, h4, .caption { break-after: avoid; }
  table { font-size: 7pt; }
  table:not(:has(tr:nth-child(40))) { break-inside: avoid; }
  th, td { padding: .1rem .3rem; }
}
)CSS"});
}

}  // namespace fricid::render
