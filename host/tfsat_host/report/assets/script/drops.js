// Which drop is looked at, and which others lie behind it in the plots.

const report = readJson("document");
const drops = report.drops;
const choice = { index: 0, behind: new Set(drops.keys()), changed: createSignal() };

const chosenDrop = () => drops[choice.index];
const letter = (index) => (index < 26 ? String.fromCharCode(65 + index) : String(index + 1));
const behindDrops = () => [...drops.keys()].filter((i) => i !== choice.index && choice.behind.has(i));

function chooseDrop(index) {
  choice.index = index;
  choice.changed.tell();
}

function layBehind(index, wanted) {
  if (wanted) choice.behind.add(index);
  else choice.behind.delete(index);
  choice.changed.tell();
}
