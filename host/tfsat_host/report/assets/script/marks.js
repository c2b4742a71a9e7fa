// Symbols and letters along lines, for eyes and printers without color: which component, which body, which drop.

const MARK_EVERY_PX = 150;

function paintSymbol(ctx, line, x, y, size, color) {
  ctx.fillStyle = palette().paper;
  ctx.strokeStyle = color;
  ctx.lineWidth = size / 2.4;
  const text = line.inFront ? line.twin && String(line.twin) : letter(line.index);
  if (text) {
    ctx.font = `600 ${size * 2.9}px ${palette().font}`;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.strokeStyle = palette().paper;
    ctx.lineWidth = size * 1.2;
    ctx.strokeText(text, x, y);
    ctx.fillStyle = color;
    ctx.fillText(text, x, y);
    return;
  }
  const symbol = SYMBOLS[line.series.component];
  if (!symbol) return;
  ctx.beginPath();
  if (symbol === "circle") ctx.arc(x, y, size, 0, 2 * Math.PI);
  if (symbol === "square") ctx.rect(x - 0.9 * size, y - 0.9 * size, 1.8 * size, 1.8 * size);
  if (symbol === "triangle") {
    ctx.moveTo(x, y - 1.2 * size);
    ctx.lineTo(x + 1.1 * size, y + 0.8 * size);
    ctx.lineTo(x - 1.1 * size, y + 0.8 * size);
    ctx.closePath();
  }
  ctx.fill();
  ctx.stroke();
}

// Lines carry them at different places, so that they do not hide each other.
function markLines(plot, lines) {
  const { ctx, bbox } = plot;
  const every = MARK_EVERY_PX * uPlot.pxRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.setLineDash([]);
  ctx.lineJoin = "round";
  lines.forEach((line, order) => {
    if (!line.shown || !line.isMain) return;
    const start = every * (0.3 + ((order * 0.37) % 1));
    for (let left = start; left < bbox.width; left += every) {
      const i = nearest(line.x, plot.posToVal((left / uPlot.pxRatio), "x"));
      const value = line.series.values[i];
      const x = plot.valToPos(line.x[i], "x", true);
      if (value === null || Math.abs(x - bbox.left - left) > every / 4) continue;
      const y = plot.valToPos(value, "y", true);
      if (Number.isFinite(y)) paintSymbol(ctx, line, x, y, 3 * uPlot.pxRatio, componentColor(line.series.component));
    }
  });
  ctx.restore();
}

// The same for a legend: a piece of the line with its symbol.
function swatch(line) {
  const canvas = el("canvas", { class: "swatch", width: 68, height: 32, "aria-hidden": "true" });
  const paint = () => {
    const ctx = canvas.getContext("2d");
    const color = componentColor(line.series.component);
    ctx.clearRect(0, 0, 68, 32);
    ctx.strokeStyle = color;
    ctx.lineWidth = 4;
    ctx.setLineDash(line.dash.map((length) => 2 * length));
    ctx.beginPath();
    ctx.moveTo(2, 16);
    ctx.lineTo(66, 16);
    ctx.stroke();
    ctx.setLineDash([]);
    if (line.isMain) paintSymbol(ctx, line, 34, 16, 6, color);
  };
  paint();
  return { canvas, paint };
}
