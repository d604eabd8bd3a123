"""How the page looks, on a screen and on paper."""

from __future__ import annotations

STYLE = """
:root { color-scheme: light; --ink: #1d252c; --soft: #5d6a74; --line: #d9dfe3;
  --pass: #2f7d4f; --warn: #a86a00; --fail: #b3261e; --skip: #5d6a74; --waived: #6b4fa0; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 24px; max-width: 1180px; color: var(--ink); background: #fff;
  font: 15px/1.5 system-ui, sans-serif; }
header { border-left: 8px solid var(--pass); padding: 4px 20px; margin-bottom: 24px; }
header.fail { border-color: var(--fail); }
h1 { margin: 0; font-size: 30px; } h2 { margin: 32px 0 8px; font-size: 20px; }
p { margin: 4px 0; } .verdict { font-size: 20px; font-weight: 600; }
.path, small, .why, figcaption, footer { color: var(--soft); font-size: 13px; }
.path, code { overflow-wrap: anywhere; }
code, pre { font: 13px/1.45 ui-monospace, monospace; }
pre { padding: 12px; border: 1px solid var(--line); border-radius: 4px; white-space: pre-wrap;
  overflow-wrap: anywhere; }
.reason { color: var(--waived); }
.chip { display: inline-block; padding: 0 8px; border-radius: 9px; color: #fff; font-size: 12px;
  font-weight: 600; background: var(--skip); }
.chip.pass { background: var(--pass); } .chip.warn { background: var(--warn); }
.chip.fail, .chip.error { background: var(--fail); } .chip.waived { background: var(--waived); }
table { border-collapse: collapse; font-size: 13px; } .findings { width: 100%; }
.wide { overflow-x: auto; }
th, td { text-align: left; vertical-align: top; padding: 4px 10px 4px 0;
  border-bottom: 1px solid var(--line); overflow-wrap: anywhere; }
.grid { display: grid; gap: 20px; grid-template-columns: repeat(auto-fill, minmax(200px, 1fr)); }
figure { margin: 0; break-inside: avoid; }
img { width: 100%; image-rendering: pixelated; border: 1px solid var(--line); background: #eee; }
svg { max-width: 100%; height: auto; }
footer { margin-top: 40px; border-top: 1px solid var(--line); padding-top: 8px; }
@media print {
  body { max-width: none; padding: 0; font-size: 11px; } h2 { break-after: avoid; }
  .chip { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
  tr { break-inside: avoid; } .wide { overflow: visible; }
}
"""
