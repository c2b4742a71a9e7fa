// The answer: how good the drop is and why; prediction and measurement, what to change, the strokes; key numbers.

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

// More reasons than these would push the numbers off the first screen.
const OPEN_REASONS = 2;

function verdictOf(drop) {
  const { sentence, reasons } = drop.verdict;
  const list = (some) => (some.length > 0 ? el("ul", {}, ...some.map((reason) => said(reason, "li"))) : null);
  const rest = list(reasons.slice(OPEN_REASONS));
  return el(
    "section",
    { class: `verdict ${levelOf(drop)}`, "aria-labelledby": "verdict-head" },
    el("h2", { id: "verdict-head" }, levelMark(drop)),
    said(sentence, "p"),
    list(reasons.slice(0, OPEN_REASONS)),
    rest && folded(`All ${reasons.length} reasons`, rest),
  );
}

function predictionOf({ prediction, change }) {
  return el(
    "section",
    { class: "prediction", "aria-labelledby": "prediction-head" },
    said(prediction.title, "h2", { id: "prediction-head" }),
    scrolling(rowsUnder(prediction.title, prediction.columns, prediction.rows)),
    said(change, "p", { class: "change said" }),
  );
}

function strokesOf({ strokes }) {
  if (strokes.rows.length === 0) return null;
  return el(
    "section",
    { class: "strokes", "aria-labelledby": "strokes-head" },
    said(strokes.title, "h2", { id: "strokes-head" }),
    scrolling(rowsUnder(strokes.title, strokes.columns, strokes.rows)),
    strokes.caption ? said(strokes.caption, "p") : null,
  );
}

// What the first screen's table of strokes says is not said again.
function keyNumbersOf(drop) {
  const numbers = drop.key_numbers.filter((number) => number.row !== drop.strokes.title);
  const rows = [...new Set(numbers.map((number) => number.row).filter(Boolean))];
  return el(
    "section",
    { class: "key-numbers", "aria-labelledby": "numbers-head" },
    el("h2", { id: "numbers-head" }, "Key numbers"),
    el("p", { class: "note" }, "± is one standard deviation."),
    el("dl", {}, ...numbers.filter((number) => !number.row).map(keyNumber)),
    ...rows.map((row) => numberRow(row, numbers.filter((number) => number.row === row))),
  );
}

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
    el("h2", { id: "notes-head" }, "Data not used, default values"),
    el("ul", {}, ...drop.notes.map((note) => said(note, "li"))),
  );
}
