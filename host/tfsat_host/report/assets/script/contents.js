// The page's sections by name, and what should be on it and is not.

function contentsOf(sections) {
  const heads = sections.flatMap((section) => [...section.querySelectorAll("h2")]).filter((head) => !head.closest(".verdict, .prediction, .strokes"));
  const links = heads.map((head) => el("li", {}, el("a", { href: `#${head.id}` }, head.textContent)));
  return el("nav", { class: "contents", "aria-label": "On this page" }, el("ul", {}, ...links));
}

function lackingDrops() {
  const lacking = report.lacking ?? [];
  if (lacking.length === 0) return null;
  return el(
    "section",
    { class: "lacking", "aria-labelledby": "lacking-head" },
    el("h2", { id: "lacking-head" }, "Not all drops are in this report"),
    el("ul", {}, ...lacking.map((text) => said(text, "li"))),
  );
}
