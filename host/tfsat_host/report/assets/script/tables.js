// The document's tables, and the licences of what the page is drawn with.

// A table wider than the page scrolls by itself, by keyboard too.
const scrolling = (table) => el("div", { class: "scrolling", tabindex: "0", role: "region", "aria-label": "Table" }, table);

const LOOKS_LIKE_NUMBER = /^[−+-]?[\d.,]+( ?± ?[\d.,]+)?( ?[^\d\s]{1,8})?$/;

function tableOf({ title, columns, rows, caption }) {
  return el(
    "section",
    { class: "table" },
    said(title, "h3"),
    scrolling(
      el(
        "table",
        {},
        said(caption || title, "caption"),
        el("thead", {}, el("tr", {}, ...columns.map(columnHead))),
        el("tbody", {}, ...rows.map((row) => el("tr", {}, ...row.map(cell)))),
      ),
    ),
  );
}

function columnHead(text) {
  const head = said(text, "th");
  head.setAttribute("scope", "col");
  return head;
}

function cell(text, column) {
  const made = said(text, column === 0 ? "th" : "td");
  if (column === 0) made.setAttribute("scope", "row");
  else if (LOOKS_LIKE_NUMBER.test(text)) made.classList.add("number");
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
