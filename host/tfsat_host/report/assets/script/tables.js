// The document's tables, and the licences of what the page is drawn with.

// A table wider than the page scrolls by itself, by keyboard too.
const scrolling = (table) => el("div", { class: "scrolling", tabindex: "0", role: "region", "aria-label": "Table" }, table);

const LOOKS_LIKE_NUMBER = /^[−+-]?[\d.,]+( ?± ?[\d.,]+)?( ?[^\d\s]{1,8})?$/;

const WIDE_COLUMNS = 5;

function tableOf({ title, columns, rows, caption, fold }) {
  const open = fold ? rows.slice(0, fold.first) : rows;
  const isWide = columns.length > WIDE_COLUMNS || fold;
  return el(
    "section",
    { class: isWide ? "table wide" : "table" },
    said(title, "h3"),
    caption ? said(caption, "p") : null,
    open.length > 0 ? scrolling(rowsUnder(title, columns, open)) : null,
    fold ? folded(fold.words, scrolling(rowsUnder(`${title}: ${fold.words}`, columns, rows.slice(fold.first)))) : null,
  );
}

const rowsUnder = (name, columns, rows) =>
  el(
    "table",
    { "aria-label": name },
    el("thead", {}, el("tr", {}, ...columns.map((text) => said(text, "th", { scope: "col" })))),
    el("tbody", {}, ...rows.map((row) => el("tr", {}, ...row.map(cell)))),
  );

// Paper has nothing to click on: what is folded is printed as well.
function folded(words, content) {
  const details = el("details", { class: "folded" }, said(words, "summary"), content);
  addEventListener("beforeprint", () => (details.open = true));
  return details;
}

const SHORT_TEXT = 22;
const LONG_TEXT = 60;

function cell(text, column) {
  const made = column === 0 ? said(text, "th", { scope: "row" }) : said(text, "td");
  if (column > 0 && LOOKS_LIKE_NUMBER.test(text)) made.classList.add("number");
  // On a narrow screen the table scrolls rather than break its names and squeeze its sentences.
  made.classList.toggle("short", text.length <= SHORT_TEXT);
  made.classList.toggle("long", text.length > LONG_TEXT);
  // Words wrap whole; only what no column could hold is broken anywhere.
  made.classList.toggle("unbroken", /\S{25}/.test(text));
  return made;
}

function tablesOf(drop) {
  if (drop.tables.length === 0) return null;
  return el(
    "section",
    { class: "tables", "aria-labelledby": "tables-head" },
    el("h2", { id: "tables-head" }, "Details"),
    el("div", { class: "all-tables" }, ...drop.tables.map(tableOf)),
  );
}

function licencesOf() {
  const texts = Object.entries(readJson("licences"));
  return el(
    "details",
    { class: "licences" },
    el("summary", {}, `Drawn with ${texts.map(([name]) => name).join(" and ")}: their licences`),
    ...texts.map(([name, text]) => el("div", {}, el("h3", {}, name), el("pre", {}, text))),
  );
}
