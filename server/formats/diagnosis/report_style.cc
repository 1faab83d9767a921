#include "server/formats/diagnosis/report_style.h"

namespace driftwise::formats {

std::string_view report_style() {
  return R"css(
:root{color-scheme:light dark;--page:#F4F6F8;--panel:#FFF;--text:#16202A;--muted:#4F5B67;--line:#D5DBE1;--grid:#E6EAEE;--zero:#7A8691;
--q1:#433BCF;--q2:#9E1D0B;--q3:#0A9C82;--s4:#A77DDF;--s5:#BB7F0A;--s6:#2B333C;--good:#0073AA;--warn:#7A6F00;--bad:#8D0044}
@media(prefers-color-scheme:dark){:root{--page:#0F1419;--panel:#181F27;--text:#E6EBF0;--muted:#A3AFBA;--line:#2E3944;--grid:#26303A;--zero:#7A8691;
--q1:#7376FF;--q2:#C85D32;--q3:#B1FFB9;--s4:#A198B3;--s5:#F4A823;--s6:#EEF2F6;--good:#59E8FC;--warn:#FFE85C;--bad:#E0616A}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--text);font:15px/1.5 system-ui,sans-serif;font-variant-numeric:tabular-nums}
main{max-width:1200px;margin:0 auto;padding:24px 16px 48px}
h1{font-size:20px;margin:0}h2{font-size:17px;margin:0 0 4px}h3{font-size:15px;margin:0 0 4px}p{margin:0 0 8px}
.note{font-size:13px;color:var(--muted);margin:0}.note code,p code,td code{font:13px ui-monospace,monospace}
code{overflow-wrap:anywhere}
section{background:var(--panel);border:1px solid var(--line);border-radius:8px;padding:16px;margin-top:16px}
.verdict{display:flex;flex-wrap:wrap;gap:16px 48px;align-items:center;justify-content:space-between}
.state{display:flex;align-items:center;gap:16px;font-size:44px;line-height:1.1;font-weight:700}
.state svg{width:36px;height:36px;flex:none}.shape-good{fill:var(--good)}.shape-warn{fill:var(--warn)}
.result{text-align:right}.result b{font-size:28px;white-space:nowrap}.result .unit,.from{color:var(--muted);font-weight:400}
.pair{display:grid;grid-template-columns:1fr 1fr;gap:16px}.wide{grid-column:1/-1}
.pair>*{min-width:0}.pair+.pair{margin-top:16px}h2+.pair{margin-top:8px}tbody th{white-space:nowrap}td .bar{margin-top:4px}
.finding{display:grid;grid-template-columns:minmax(0,1fr) 260px;gap:8px 32px}
.finding .worth{text-align:left}.worth b{font-size:28px;display:block}
.finding .evidence{max-width:560px}
svg{display:block;width:100%;height:auto}
.grid{stroke:var(--grid);fill:none}.zero{stroke:var(--zero);stroke-width:1.5;fill:none}.band{fill:var(--q1);opacity:.12}
.mark{stroke:var(--s5);stroke-width:1.5;stroke-dasharray:5 4;fill:none}
.tick{font:13px system-ui,sans-serif;fill:var(--muted)}.end{text-anchor:end}.middle{text-anchor:middle}
.points{stroke-width:3.4;stroke-linecap:round;fill:none}.diamonds{stroke-width:1.1;fill:none}.span{stroke-width:1;fill:none}
.curve{stroke-width:2;fill:none}
path.q1{stroke:var(--q1)}path.q2{stroke:var(--q2)}path.q3{stroke:var(--q3)}path.s4{stroke:var(--s4)}path.s5{stroke:var(--s5)}path.s6{stroke:var(--s6)}
table{border-collapse:collapse;width:100%}th{font-size:13px;font-weight:400;color:var(--muted);text-align:left}
th,td{padding:6px 8px;border-bottom:1px solid var(--line);vertical-align:top}
tr:last-child>*{border-bottom:0}.number{text-align:right;white-space:nowrap}
caption{text-align:left;font-size:13px;color:var(--muted);padding:0 8px 4px}
.scroll{overflow-x:auto}
.bars td{border:0;padding:3px 8px}.bars td:first-child{width:9em}.bars td:last-child{width:5em}
.bar{height:14px;width:100%}.bar-back{fill:var(--grid)}.bar-front{fill:var(--q1)}
.key{display:inline-block;font-size:13px;color:var(--muted);margin-right:16px}.key svg{display:inline-block;width:14px;height:14px;vertical-align:-2px;margin-right:4px}
details{margin-top:8px}summary{cursor:pointer;color:var(--good)}summary:focus-visible{outline:2px solid var(--good);outline-offset:2px}
pre{margin:8px 0 0;padding:8px;max-height:320px;overflow:auto;border:1px solid var(--line);border-radius:8px;font:13px ui-monospace,monospace}
footer{margin-top:16px}
@media(max-width:720px){.pair,.finding{grid-template-columns:minmax(0,1fr)}.result{text-align:left}.state{font-size:34px}main{padding:16px 12px 32px}.tick{font-size:16px}}
@media print{:root{--page:#FFF}section{break-inside:avoid}details:not([open])>*{display:block}}
)css";
}

std::string_view report_style_hash() {
  return "sha256-3zxkP3Z1pD7ciqhFFFVzzfeNqY0YhNyxskXKPQhrkI0=";
}

}  // namespace driftwise::formats
