// Strokes and events by name, on the same time axis as the plots below.

const LANE_PX = 22;
const LANES = 3;
const NAME_GAP_PX = 6;

function createTimeline(group) {
  const drop = chosenDrop();
  const events = [...drop.events].sort((a, b) => a.t_s - b.t_s);
  const place = el("div", { class: "drawing" });
  const { cursor, view } = group;
  const zoom = (label, text, act) => el("button", { type: "button", "aria-label": label, title: label, on: { click: act } }, text);
  const figure = el(
    "figure",
    { class: "plot timeline", tabindex: "0", role: "group", "aria-label": "Strokes and events over time" },
    el(
      "figcaption",
      {},
      el("h3", {}, "Strokes and events"),
      el(
        "span",
        { class: "zoom" },
        zoom("Zoom the time plots in", "+", () => view.zoom(0.5, cursor.now)),
        zoom("Zoom the time plots out", "−", () => view.zoom(2, cursor.now)),
        zoom("Show the whole drop", "All", () => view.reset()),
      ),
    ),
    place,
    el("p", { class: "legend-note" }, "Blue: a joint moves. Violet: samples lost. Gray: not evaluated."),
  );
  let chart = null;
  return {
    figure,
    mount(width) {
      const shared = axesOf({ x_label: "", y_label: "" }, group.view, false);
      const names = el("div", { class: "names" });
      const options = {
        ...shared,
        axes: [shared.axes[0], { ...shared.axes[1], values: () => [], ticks: { show: false }, grid: { show: false } }],
        scales: { ...shared.scales, y: { range: () => [0, 1] } },
        series: [{}, { show: false }],
        hooks: {
          drawClear: [(plot) => shadeDrop(plot, drop)],
          draw: [(plot) => (ruleMoments(plot, drop), nameEvents(plot, names, events))],
        },
      };
      const xs = [group.view.min, group.view.max];
      chart = createChart(place, group, options, [xs, [null, null]], width, LANES * LANE_PX + 16);
      describeChart(chart, `Strokes and events: ${events.map((event) => `${event.label} at ${seconds(event.t_s)}`).join("; ")}.`);
      chart.uplot.over.append(names);
    },
    destroy() {
      chart.destroy();
    },
  };
}

// Strokes first, all in the longest form for which there is room; then moments, each as long as its room allows.
function nameEvents(plot, place, events) {
  const width = plot.bbox.width / uPlot.pxRatio;
  const visible = events.map((event) => ({ event, ends: endsOf(plot, event) })).filter(({ ends }) => ends[1] >= 0 && ends[0] <= width);
  const spans = visible.filter(({ event }) => isSpan(event));
  const measure = plot.ctx;
  measure.save();
  measure.font = `12px ${palette().font}`;
  const placed = [0, 1, 2].map((form) => placeNames([], spans, form)).find((names) => names.length === spans.length) ?? [];
  for (const moment of visible.filter(({ event }) => !isSpan(event))) {
    const longer = [0, 1, 2].map((form) => placeNames(placed, [moment], form)).find((names) => names.length > 0);
    placed.push(...(longer ?? []));
  }
  measure.restore();
  place.replaceChildren(...placed.map(nameElement));

  // Each in the first lane where it touches no other.
  function placeNames(others, wanted, form) {
    const names = [];
    for (const { event, ends } of wanted) {
      const text = namesOf(event)[form];
      const length = measure.measureText(text).width + NAME_GAP_PX;
      const start = isSpan(event) ? (ends[0] + ends[1] - length) / 2 : ends[0] + 4;
      const left = Math.max(2, Math.min(width - length, start));
      const isFree = (lane) => [...others, ...names].every((name) => name.lane !== lane || name.left + name.length <= left || name.left >= left + length);
      const lane = [...Array(LANES).keys()].find(isFree);
      if (lane !== undefined) names.push({ event, text, left, length, lane });
    }
    return names;
  }
}

const endsOf = (plot, event) => [event.t_s, isSpan(event) ? event.until_s : event.t_s].map((t) => plot.valToPos(t, "x"));

function nameElement({ event, text, left, lane }) {
  const element = said(text, "span", { class: event.kind === "stroke" ? "stroke-name" : "moment-name" });
  element.style.transform = `translate(${left}px, ${lane * LANE_PX + 4}px)`;
  return element;
}

// Of "2: joint 1, +59.0 deg" also "2: joint 1" and "2".
const namesOf = ({ label }) => [label, label.split(",")[0], label.split(":")[0]].map(clipped);

const LONGEST_NAME = 28;
const clipped = (text) => (text.length > LONGEST_NAME ? `${text.slice(0, LONGEST_NAME)}…` : text);
