// Colors come from the style sheet, so that screen, dark screen and paper have one source; shapes of lines stand
// beside them, because colors alone reach neither every eye nor every printer.

const SOLID = [];
const DASHES = { measured: SOLID, before: [9, 5], after: [10, 4, 2, 4], commanded: [2, 4] };
const SYMBOLS = ["circle", "triangle", "square", null];

const darkScreen = matchMedia("(prefers-color-scheme: dark)");
const paletteChanged = createSignal();
let colors = null;

function palette() {
  if (colors) return colors;
  const style = getComputedStyle(document.documentElement);
  const read = (name) => style.getPropertyValue(`--${name}`).trim();
  colors = {
    ink: read("ink"),
    quiet: read("quiet"),
    rule: read("rule"),
    paper: read("paper"),
    stroke: read("stroke-span"),
    gap: read("gap-span"),
    band: read("band-span"),
    outside: read("outside-span"),
    components: [0, 1, 2, 3].map((i) => read(`component-${i}`)),
    bodies: [0, 1, 2, 3].map((i) => read(`body-${i}`)),
    font: style.getPropertyValue("font-family"),
  };
  return colors;
}

function forgetColors() {
  colors = null;
  paletteChanged.tell();
}

darkScreen.addEventListener("change", forgetColors);

// Paper is white, whatever the screen was, and as wide as A4 between its margins: the browser lays out a printed
// page after this event, too late for what is drawn.
const PAPER_WIDTH_PX = 680;
const onPaper = () => document.documentElement.hasAttribute("data-paper");

for (const [event, printing] of [["beforeprint", true], ["afterprint", false]]) {
  addEventListener(event, () => {
    document.documentElement.toggleAttribute("data-paper", printing);
    forgetColors();
  });
}

const componentColor = (component) => palette().components[component] ?? palette().ink;
const bodyColor = (index) => palette().bodies[index % 4];

// "#rrggbb" as red, green, blue, opacity between 0 and 1; the style sheet writes the bodies' colors so.
function channels(hex, opacity = 1) {
  const bits = Number.parseInt(hex.slice(1), 16);
  return [(bits >> 16) / 255, ((bits >> 8) & 255) / 255, (bits & 255) / 255, opacity];
}
