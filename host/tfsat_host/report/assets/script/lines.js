// A plot's lines as uPlot wants them: one x, and columns for values and for both edges of the uncertainty.
// With several drops the chosen one is drawn in full; of the others only the main lines lie behind it.

// What a line is: whose, and whether it is drawn in front. `low` and `high` are its band's columns.
function linesOf(id) {
  const lines = [];
  const blocks = [];
  let column = 1;
  for (const index of [choice.index, ...behindDrops()]) {
    const plot = drops[index].plots.find((each) => each.id === id);
    if (!plot) continue;
    const inFront = index === choice.index;
    const x = plot.x ?? drops[index].t_s;
    const block = [x];
    const main = mainOf(plot.series);
    for (const series of inFront ? plot.series : main) {
      const isMain = main.includes(series);
      const line = { series, inFront, index, x, column, shown: true, isMain, dash: isMain ? SOLID : dashOf(series) };
      block.push(drawable(series.values, plot.log_y));
      column += 1;
      // Bands of all lines would hide each other; the legend tells every line's deviation.
      if (inFront && isMain && series.std) {
        block.push(edge(series, 1, plot.log_y), edge(series, -1, plot.log_y));
        [line.high, line.low] = [column, column + 1];
        column += 2;
      }
      lines.push(line);
    }
    blocks.push(block);
  }
  countTwins(lines);
  return { lines, data: blocks.length > 1 ? uPlot.join(blocks) : blocks[0] };
}

// What was measured; where nothing was, the best that the model says. These lines are solid and bear marks.
function mainOf(series) {
  const best = ["measured", "after"].find((kind) => series.some((each) => each.kind === kind));
  return best ? series.filter((each) => each.kind === best) : series;
}

const dashOf = ({ kind }) => (Object.hasOwn(DASHES, kind) ? DASHES[kind] : SOLID);

const drawable = (values, isLog) => (isLog ? values.map((value) => (value > 0 ? value : null)) : values);

function edge(series, sign, isLog) {
  const at = (value, i) => (value === null || series.std[i] === null ? null : value + sign * series.std[i]);
  return drawable(series.values.map(at), isLog);
}

// Lines alike in color and style (the same axis of several bodies) get a number to tell them by.
function countTwins(lines) {
  const front = lines.filter((line) => line.inFront);
  const alike = (a, b) => a.series.component === b.series.component && a.series.kind === b.series.kind;
  for (const line of front) {
    const twins = front.filter((other) => alike(line, other));
    if (twins.length > 1) line.twin = twins.indexOf(line) + 1;
  }
}

// Index of the sample nearest to x.
function nearest(xs, x) {
  let [low, high] = [0, xs.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle;
    else high = middle;
  }
  return Math.abs(xs[high] - x) < Math.abs(x - xs[low]) ? high : low;
}
