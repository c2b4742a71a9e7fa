// Scales and ticks, the same for all plots, so that linked ones stand exactly above each other.

const LEFT_PX = 66;
const RIGHT_PX = 14;

const plotFont = (size) => `${size}px ${palette().font}`;

function axesOf({ x_label, y_label, log_x = false, log_y = false }, view, showsX = true) {
  const ruled = {
    stroke: () => palette().quiet,
    grid: { stroke: () => palette().rule, width: 1 },
    ticks: { stroke: () => palette().rule, width: 1, size: 5 },
    font: plotFont(12),
    labelFont: plotFont(12),
    labelGap: 2,
  };
  return {
    padding: [10, RIGHT_PX, showsX ? 0 : 4, 0],
    scales: {
      // uPlot would snap a logarithmic axis to whole decades; what is shown is the view's affair.
      x: { time: false, distr: log_x ? 3 : 1, range: () => [view.min, view.max] },
      y: log_y ? { distr: 3, range: (plot, low, high) => decadesBetween(Math.max(low, highest(plot) * FLOOR_SHARE), high) } : { distr: 1 },
    },
    axes: [
      { ...ruled, label: x_label, labelSize: 20, size: 32, show: showsX, values: log_x ? decades : plain },
      { ...ruled, label: y_label, labelSize: 20, size: LEFT_PX - 20, values: log_y ? decades : plain },
    ],
  };
}

// What lies so far below a spectrum's peak is rounding, and would press the rest together.
const FLOOR_SHARE = 1e-5;

function highest(plot) {
  let most = 0;
  plot.series.forEach((series, i) => {
    if (i > 0 && series.show) for (const value of plot.data[i]) if (value > most) most = value;
  });
  return most;
}

function decadesBetween(low, high) {
  if (!(low > 0 && high > 0)) return [0.1, 1];
  const [from, to] = [Math.floor(Math.log10(low) + 1e-9), Math.ceil(Math.log10(high) - 1e-9)];
  return [10 ** from, 10 ** Math.max(to, from + 1)];
}

// Ticks beyond thousands and thousandths share one power of ten, which stands with each of them.
function plain(plot, values) {
  const power = powerOf(Math.max(...values.map((value) => Math.abs(value ?? 0))));
  return values.map((value) => {
    if (value === null) return "";
    const text = tidy(Number((value / 10 ** power).toPrecision(6)));
    return power === 0 || value === 0 ? text : `${text}×10${superscript(power)}`;
  });
}

// Powers of ten by name, far from one as powers; what uPlot left out stays out.
function decades(plot, values) {
  return values.map((value) => {
    if (value === null) return "";
    const power = Math.log10(value);
    if (Math.abs(power) <= 3) return tidy(Number(value.toPrecision(3)));
    return Math.abs(power - Math.round(power)) > 1e-6 ? "" : `10${superscript(Math.round(power))}`;
  });
}

const tidy = (value) => String(value).replace("-", "−");
