// A uPlot in a group: as wide as its place, with the group's span of x and the group's cursor.

const NARROWEST_PX = 240;

function createChart(place, group, options, data, firstWidth, height) {
  const widthNow = () => (onPaper() ? PAPER_WIDTH_PX : Math.max(NARROWEST_PX, place.clientWidth));
  const hairline = el("div", { class: "hairline" });
  const { draw = [], ...hooks } = options.hooks;
  const chart = new uPlot(
    {
      ...options,
      width: Math.max(NARROWEST_PX, firstWidth),
      height,
      cursor: { show: false },
      legend: { show: false },
      pxAlign: 0,
      // A new scale holds from the next drawing on, and so does the hairline's place.
      hooks: { ...hooks, ready: [(plot) => plot.over.append(hairline)], draw: [...draw, follow] },
    },
    data,
    place,
  );

  function follow(chart) {
    const left = chart.valToPos(group.cursor.now, "x");
    hairline.hidden = !(left >= 0 && left <= chart.bbox.width / uPlot.pxRatio);
    if (!hairline.hidden) hairline.style.transform = `translateX(${left}px)`;
  }
  const rescale = () => chart.setScale("x", { min: group.view.min, max: group.view.max });
  function resize() {
    const width = widthNow();
    if (width !== chart.width) chart.setSize({ width, height });
  }
  const sizes = new ResizeObserver(resize);
  sizes.observe(place);
  const stops = [group.cursor.on(() => follow(chart)), group.view.on(rescale), paletteChanged.on(() => (resize(), chart.redraw()))];
  followPointer(chart, group);
  return {
    uplot: chart,
    destroy() {
      sizes.disconnect();
      for (const stop of stops) stop();
      chart.destroy();
    },
  };
}

// The drawing in words, for those who do not see it.
function describeChart({ uplot }, text) {
  uplot.ctx.canvas.setAttribute("role", "img");
  uplot.ctx.canvas.setAttribute("aria-label", text);
}
