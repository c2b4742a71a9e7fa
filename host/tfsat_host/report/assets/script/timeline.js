// Strokes and events by name, on the same time axis as the plots below.

const LANE_PX = 22;
const LANES = 3;

function createTimeline(group) {
  const drop = chosenDrop();
  const events = [...drop.events].sort((a, b) => a.t_s - b.t_s);
  const place = el("div", { class: "drawing" });
  const figure = el(
    "figure",
    { class: "plot timeline", tabindex: "0", role: "group", "aria-label": "Strokes and events over time" },
    el("figcaption", {}, el("h3", {}, "Strokes and events")),
    place,
    el("p", { class: "legend-note" }, "Blue: a joint moves. Violet: samples are missing. Gray: not evaluated."),
  );
  let chart = null;
  return {
    figure,
    mount(width) {
      const shared = axesOf({ x_label: "", y_label: "" }, group.view, false);
      const options = {
        ...shared,
        axes: [shared.axes[0], { ...shared.axes[1], values: () => [], ticks: { show: false }, grid: { show: false } }],
        scales: { ...shared.scales, y: { range: () => [0, 1] } },
        series: [{}, { show: false }],
        hooks: {
          drawClear: [(plot) => shadeDrop(plot, drop)],
          draw: [(plot) => (ruleMoments(plot, drop), nameEvents(plot, events))],
        },
      };
      const xs = [group.view.min, group.view.max];
      chart = createChart(place, group, options, [xs, [null, null]], width, LANES * LANE_PX + 16);
    },
    destroy() {
      chart.destroy();
    },
  };
}

// Each name in the first lane where it touches no other; strokes first, and in short where there is no room.
function nameEvents(plot, events) {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  const taken = Array.from({ length: LANES }, () => []);
  ctx.save();
  ctx.font = `${12 * ratio}px ${palette().font}`;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  for (const event of [...events.filter(isSpan), ...events.filter((each) => !isSpan(each))]) {
    const from = plot.valToPos(event.t_s, "x", true);
    const to = isSpan(event) ? plot.valToPos(event.until_s, "x", true) : from;
    if (to < bbox.left || from > bbox.left + bbox.width) continue;
    for (const text of namesOf(event)) {
      const width = ctx.measureText(text).width;
      const wanted = isSpan(event) ? (from + to - width) / 2 : from + 4 * ratio;
      const left = Math.max(bbox.left + 2 * ratio, Math.min(bbox.left + bbox.width - width - 2 * ratio, wanted));
      const [begin, end] = [left - 4 * ratio, left + width + 4 * ratio];
      const lane = taken.findIndex((names) => names.every(([first, last]) => end < first || begin > last));
      if (lane < 0) continue;
      taken[lane].push([begin, end]);
      ctx.fillStyle = isSpan(event) ? palette().ink : palette().quiet;
      ctx.fillText(text, left, bbox.top + (lane + 0.6) * LANE_PX * ratio);
      break;
    }
  }
  ctx.restore();
}

// Of "2: joint 1, +59.0 deg" also "2: joint 1" and "2".
function namesOf({ label }) {
  const names = [label, label.split(",")[0], label.split(":")[0]];
  return [...new Set(names)].map(clipped);
}

const LONGEST_NAME = 28;
const clipped = (text) => (text.length > LONGEST_NAME ? `${text.slice(0, LONGEST_NAME)}…` : text);
