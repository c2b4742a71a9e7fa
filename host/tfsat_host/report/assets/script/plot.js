// One plot of the document: lines over shaded strokes or band, a legend that reads the cursor, a caption.

const PLOT_HEIGHT_PX = 232;

function createPlot(plot, group) {
  const { lines, data } = linesOf(plot.id);
  const place = el("div", { class: "drawing" });
  const legend = createLegend(lines, (line) => switchLine(chart.uplot, line));
  const figure = el(
    "figure",
    { class: "plot", tabindex: "0", role: "group", "aria-label": `Plot: ${plot.title}`, "data-plot": plot.id },
    el("figcaption", {}, said(plot.title, "h3")),
    plot.withheld ? said(plot.withheld, "p", { class: "withheld said" }) : null,
    place,
    legend.list,
    plot.caption ? said(plot.caption, "p") : null,
  );
  let chart = null;
  let stops = [];
  place.hidden = lines.length === 0;
  return {
    figure,
    // Only what is on the page has a width to draw for.
    mount(width) {
      if (lines.length === 0) return;
      chart = createChart(place, group, optionsOf(plot, group, lines), data, width, PLOT_HEIGHT_PX);
      describeChart(chart, `${plot.title}: ${plot.y_label}. Lines: ${plot.series.map((series) => series.label).join(", ")}.`);
      const read = () => legend.read(group.cursor.now);
      stops = [group.cursor.on(read), paletteChanged.on(legend.repaint)];
      read();
    },
    destroy() {
      for (const stop of stops) stop();
      chart?.destroy();
    },
  };
}

function optionsOf(plot, group, lines) {
  const overTime = plot.x === null;
  return {
    ...axesOf(plot, group.view),
    series: seriesOf(lines),
    bands: lines.filter((line) => line.high).map(bandOf),
    hooks: {
      drawClear: [
        (chart) => {
          if (overTime) shadeDrop(chart, chosenDrop());
          else if (plot.band) shade(chart, plot.band[0], plot.band[1], palette().band);
        },
      ],
      draw: [
        (chart) => {
          if (overTime) ruleMoments(chart, chosenDrop());
          markLines(chart, lines);
        },
      ],
    },
  };
}

function seriesOf(lines) {
  const series = [{}];
  for (const line of lines) {
    const color = () => componentColor(line.series.component);
    series[line.column] = {
      stroke: color,
      width: line.isMain && line.inFront ? 1.75 : 1.25,
      alpha: line.inFront ? (line.isMain ? 1 : 0.85) : 0.55,
      dash: line.dash,
      points: { show: false },
    };
    if (line.high) {
      const silent = { stroke: "transparent", width: 0, points: { show: false } };
      series[line.high] = { ...silent };
      series[line.low] = { ...silent };
    }
  }
  return series;
}

const bandOf = (line) => ({
  series: [line.high, line.low],
  fill: () => `color-mix(in srgb, ${componentColor(line.series.component)} 20%, transparent)`,
});

function switchLine(chart, line) {
  chart.batch(() => {
    for (const column of [line.column, line.high, line.low]) {
      if (column) chart.setSeries(column, { show: line.shown });
    }
  });
}
