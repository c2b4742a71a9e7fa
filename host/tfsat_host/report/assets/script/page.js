// All of it: what stays while the page is open, and what is made anew for each chosen drop.

const FORMAT = 2;

// Every plot's group: time for plots over the drop's time, else one for each kind of x.
function createGroups() {
  const drop = chosenDrop();
  const groups = new Map();
  const shown = [drop, ...behindDrops().map((index) => drops[index])];
  const ends = (xs) => [Math.min(...xs.map((x) => x[0])), Math.max(...xs.map((x) => x[x.length - 1]))];
  const times = shown.map((each) => each.t_s).filter((x) => x.length > 0);
  const time = createGroup(...(times.length > 0 ? ends(times) : [0, 1]));
  time.player = createPlayer(time.cursor);
  return {
    time,
    of(plot) {
      if (plot.x === null) return time;
      if (!groups.has(plot.x_label)) {
        const alike = drop.plots.filter((each) => each.x !== null && each.x_label === plot.x_label && each.x.length > 0);
        const xs = alike.map((each) => (each.log_x ? each.x.filter((x) => x > 0) : each.x));
        groups.set(plot.x_label, createGroup(...ends(xs), plot.log_x));
      }
      return groups.get(plot.x_label);
    },
  };
}

function showPage() {
  document.title = report.title;
  const main = el("main", {});
  const replay = createReplay();
  let undo = [];
  let groupOf = new Map();
  let groups = null;

  function showDrop() {
    const before = groups?.time;
    for (const each of undo) each();
    const drop = chosenDrop();
    groups = createGroups();
    // What the robot came to is what one wants to see first.
    if (before) groups.time.cursor.set(before.cursor.now);
    else groups.time.cursor.open(drop.window_s[1]);
    const timeline = createTimeline(groups.time);
    const drawable = drop.plots.filter((plot) => (plot.x ?? drop.t_s).length > 1);
    const plots = drawable.map((plot) => ({ overTime: plot.x === null, group: groups.of(plot), ...createPlot(plot, groups.of(plot)) }));
    const transport = createTransport(groups.time, replay.modelChoice);
    groupOf = new Map(plots.map((plot) => [plot.figure, plot.group]));
    const sections = sectionsOf(drop, timeline, plots, replay, transport).filter(Boolean);
    main.replaceChildren(contentsOf(sections), ...sections);
    // All widths before the first drawing: each would have the browser lay out the page anew.
    const charts = [timeline, ...plots].map((each) => ({ each, width: each.figure.clientWidth }));
    for (const { each, width } of charts) each.mount(width);
    undo = [replay.show(groups.time), transport.destroy, timeline.destroy, ...plots.map((plot) => plot.destroy)];
  }

  document.body.append(header(), ...[lackingDrops(), drops.length > 1 ? dropChooser() : null].filter(Boolean), main, footer());
  listenToKeys((element) => groupOf.get(element?.closest("figure.plot")) ?? groups.time, replay);
  choice.changed.on(showDrop);
  showDrop();
}

function sectionsOf(drop, timeline, plots, replay, transport) {
  const figures = (overTime) => plots.filter((plot) => plot.overTime === overTime).map((plot) => plot.figure);
  const spectra = figures(false);
  return [
    verdictOf(drop),
    el(
      "div",
      { class: "answer" },
      predictionOf(drop),
      el("div", { class: "watch" }, replay.element, transport.element, keysHelp()),
      strokesOf(drop),
      el(
        "div",
        { class: "further" },
        drops.length > 1 ? comparisonSection() : null,
        keyNumbersOf(drop),
        notesOf(drop),
        el(
          "section",
          { class: "motion", "aria-labelledby": "motion-head" },
          el("h2", { id: "motion-head" }, "The drop over time"),
          el("div", { class: "plots" }, timeline.figure, ...figures(true)),
        ),
      ),
    ),
    spectra.length > 0
      ? el(
          "section",
          { class: "spectra", "aria-labelledby": "spectra-head" },
          el("h2", { id: "spectra-head" }, drop.plots.every((plot) => plot.x === null || plot.log_x) ? "Spectra" : "Further plots"),
          el("div", { class: "plots" }, ...spectra),
        )
      : null,
    tablesOf(drop),
  ];
}

const header = () =>
  el(
    "header",
    {},
    said(report.title, "h1"),
    el("p", { class: "made" }, said(report.made_by), " · ", said(report.made_at)),
  );

const footer = () =>
  el(
    "footer",
    {},
    el("p", {}, "Works offline: this file loads nothing from a network."),
    licencesOf(),
  );

if (report.format !== FORMAT || drops.length === 0) {
  const why = drops.length === 0 ? "holds no drop" : `has format ${report.format}, this page shows format ${FORMAT}`;
  document.body.append(el("p", { class: "note" }, `Nothing to show: the document ${why}. Make the report again: tfsat-host report`));
} else {
  showPage();
}
