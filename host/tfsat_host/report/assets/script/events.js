// Strokes, gaps and moments: shaded and ruled into a plot, and in words for a time.

const isSpan = (event) => event.until_s !== null && event.until_s !== undefined;

function shade(plot, from, to, color) {
  const { ctx, bbox } = plot;
  const left = Math.max(bbox.left, plot.valToPos(from, "x", true));
  const right = Math.min(bbox.left + bbox.width, plot.valToPos(to, "x", true));
  if (!(right > left)) return;
  ctx.fillStyle = color;
  ctx.fillRect(left, bbox.top, right - left, bbox.height);
}

function ruleAt(plot, t, color, dash) {
  const { ctx, bbox } = plot;
  const x = Math.round(plot.valToPos(t, "x", true)) + 0.5;
  if (!(x >= bbox.left && x <= bbox.left + bbox.width)) return;
  ctx.save();
  ctx.strokeStyle = color;
  ctx.lineWidth = uPlot.pxRatio;
  ctx.setLineDash(dash.map((length) => length * uPlot.pxRatio));
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}

function shadeDrop(plot, drop) {
  for (const event of drop.events.filter(isSpan)) {
    shade(plot, event.t_s, event.until_s, event.kind === "gap" ? palette().gap : palette().stroke);
    // Strokes follow each other at once: without an edge they would look like one.
    for (const t of [event.t_s, event.until_s]) ruleAt(plot, t, palette().stroke, []);
  }
  const [start, end] = drop.window_s;
  shade(plot, plot.scales.x.min, start, palette().outside);
  shade(plot, end, plot.scales.x.max, palette().outside);
}

function ruleMoments(plot, drop) {
  for (const event of drop.events.filter((each) => !isSpan(each))) ruleAt(plot, event.t_s, palette().quiet, [4, 3]);
}

const SAME_MOMENT_S = 5e-4;

function inWords(drop, t) {
  const end = Math.min(drop.window_s[1], drop.t_s.at(-1) ?? Infinity);
  if (Math.abs(t - end) < SAME_MOMENT_S) return "end of the evaluation";
  const spans = drop.events.filter((event) => isSpan(event) && t >= event.t_s && t <= event.until_s);
  if (spans.length > 0) return spans.map((event) => event.label).join(", ");
  const past = drop.events.filter((event) => event.t_s <= t);
  if (past.length === 0) return "before the first event";
  const last = past.reduce((a, b) => (b.t_s >= a.t_s ? b : a));
  return `after ${last.label}`;
}
