// Several drops: which one is shown, which lie behind it, and their key numbers side by side.

function dropChooser() {
  return el(
    "fieldset",
    { class: "drops" },
    el("legend", {}, "Drop shown (the others: behind it in the plots, by letter)"),
    ...drops.map((drop, index) => dropChoice(drop, index)),
  );
}

function dropChoice(drop, index) {
  const radio = el("input", {
    type: "radio",
    name: "drop",
    value: index,
    checked: index === choice.index,
    on: { change: () => chooseDrop(index) },
  });
  const behind = el("input", {
    type: "checkbox",
    checked: choice.behind.has(index),
    on: { change: (event) => layBehind(index, event.target.checked) },
  });
  return el(
    "div",
    { class: "drop" },
    el("label", { class: "which" }, radio, el("span", { class: "letter" }, letter(index)), said(drop.name), levelMark(drop)),
    el("label", { class: "behind" }, behind, "in the plots"),
  );
}

// Key numbers beside each other, and what the drops say of the model together.
function comparisonSection() {
  const labels = [...new Set(drops.flatMap((drop) => drop.key_numbers.map((number) => number.label)))];
  const head = drops.map((drop, index) =>
    el("th", { scope: "col" }, el("span", { class: "letter" }, letter(index)), " ", said(drop.name)));
  const verdicts = el("tr", {}, el("th", { scope: "row" }, "Verdict"), ...drops.map((drop) => el("td", {}, levelMark(drop))));
  return el(
    "section",
    { class: "tables", "aria-labelledby": "comparison-head" },
    el("h2", { id: "comparison-head" }, "Drops compared"),
    scrolling(
      el(
        "table",
        { class: "comparison" },
        el("caption", {}, "Key numbers of all drops. ± is one standard deviation."),
        el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "Key number"), ...head)),
        el("tbody", {}, verdicts, ...labels.map(comparisonRow)),
      ),
    ),
    el("div", { class: "all-tables" }, ...(report.tables ?? []).map(tableOf)),
  );
}

function comparisonRow(label) {
  const cells = drops.map((drop) => {
    const number = drop.key_numbers.find((each) => each.label === label);
    return el("td", { class: "figure" }, ...(number ? figureOf(number) : [NO_NUMBER]));
  });
  return el("tr", {}, said(label, "th"), ...cells);
}
