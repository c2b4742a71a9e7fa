// A plot's lines by name: a switch each, and the value at the cursor with its uncertainty.

function createLegend(lines, onSwitch) {
  const rows = lines.filter((line) => line.inFront).map((line) => row(line, onSwitch));
  return {
    list: el("ul", { class: "legend", "aria-label": "Lines, and their values at the cursor" }, ...rows.map((r) => r.item)),
    read(x) {
      for (const each of rows) each.read(x);
    },
    repaint() {
      for (const each of rows) each.repaint();
    },
  };
}

function row(line, onSwitch) {
  const { canvas, paint } = swatch(line);
  const value = el("span", { class: "value" });
  const std = el("span", { class: "std" });
  const button = el(
    "button",
    {
      type: "button",
      "aria-pressed": "true",
      title: "Show or hide this line",
      on: {
        click() {
          line.shown = !line.shown;
          button.setAttribute("aria-pressed", line.shown);
          onSwitch(line);
        },
      },
    },
    canvas,
    el("span", { class: "name" }, said(line.series.label)),
    value,
    std,
  );
  return {
    item: el("li", {}, button),
    repaint: paint,
    read(x) {
      const i = nearest(line.x, x);
      const written = withStd(line.series.values[i], line.series.std?.[i]);
      value.textContent = written.value;
      std.textContent = written.std === null ? "" : `± ${written.std}${written.power}`;
    },
  };
}
