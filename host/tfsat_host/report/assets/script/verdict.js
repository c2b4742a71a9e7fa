// The answer: how good the drop is and why, its key numbers, what could not be used.

const LEVELS = {
  good: { word: "Good", symbol: "✓" },
  doubtful: { word: "Doubtful", symbol: "!" },
  failed: { word: "Failed", symbol: "✕" },
};
const UNKNOWN_LEVEL = { word: "Unknown", symbol: "?" };

const levelOf = (drop) => (Object.hasOwn(LEVELS, drop.verdict.level) ? drop.verdict.level : "unknown");

// Level by symbol and word; the color only repeats it.
function levelMark(drop) {
  const level = levelOf(drop);
  const { word, symbol } = LEVELS[level] ?? UNKNOWN_LEVEL;
  return el("span", { class: `level ${level}` }, el("span", { class: "symbol", "aria-hidden": "true" }, symbol), word);
}

function verdictOf(drop) {
  const { sentence, reasons } = drop.verdict;
  return el(
    "section",
    { class: `verdict ${levelOf(drop)}`, "aria-labelledby": "verdict-head" },
    el("h2", { id: "verdict-head" }, levelMark(drop)),
    said(sentence, "p"),
    reasons.length > 0 ? el("ul", {}, ...reasons.map((reason) => said(reason, "li"))) : null,
  );
}

function keyNumbersOf(drop) {
  return el(
    "section",
    { class: "key-numbers", "aria-labelledby": "numbers-head" },
    el("h2", { id: "numbers-head" }, "Key numbers"),
    el("p", { class: "note" }, "± is one standard deviation."),
    el("dl", { class: "leading" }, ...drop.key_numbers.filter((number) => !number.row).map(keyNumber)),
    ...rowNames(drop).map((row) => numberRow(row, drop.key_numbers.filter((number) => number.row === row))),
  );
}

const rowNames = (drop) => [...new Set(drop.key_numbers.map((number) => number.row).filter(Boolean))];

const numberRow = (name, numbers) =>
  el("div", { class: "number-row" }, said(name, "h3"), el("dl", {}, ...numbers.map(keyNumber)));

const keyNumber = (number) =>
  el(
    "div",
    {},
    said(number.label, "dt"),
    el("dd", { class: "figure" }, ...figureOf(number)),
    number.note ? said(number.note, "dd") : null,
  );

function figureOf({ value, std, unit }) {
  const written = withStd(value, std);
  return [
    written.power ? "(" : null,
    el("span", { class: "value" }, written.value),
    written.std === null ? null : el("span", { class: "std" }, ` ± ${written.std}`),
    written.power ? `)${written.power}` : null,
    written.value === NO_NUMBER ? null : el("span", { class: "unit" }, " ", said(unit)),
  ];
}

function notesOf(drop) {
  if (drop.notes.length === 0) return null;
  return el(
    "section",
    { class: "unused", "aria-labelledby": "notes-head" },
    el("h2", { id: "notes-head" }, "What could not be used"),
    el("ul", {}, ...drop.notes.map((note) => said(note, "li"))),
  );
}
