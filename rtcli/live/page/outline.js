// Outlines of objects, from the pass of ids.

// The rectangle of pixels of each id: [left, top, right, bottom], inclusive.
function boxes({ values, width }) {
  const found = new Map();
  for (let at = 0, x = 0, y = 0; at < values.length; at++) {
    const box = found.get(values[at]);
    if (!box) {
      found.set(values[at], [x, y, x, y]);
    } else {
      if (x < box[0]) box[0] = x;
      if (x > box[2]) box[2] = x;
      if (y > box[3]) box[3] = y;
    }
    if (++x === width) [x, y] = [0, y + 1];
  }
  return found;
}

export class Outlines {
  constructor(ids) {
    this.ids = ids;
    this.boxes = boxes(ids);
    this.paths = new Map();
  }

  // The edges between the pixels of an object and all others, in pixels of the picture; null if it is not seen.
  of(index) {
    const id = index + 1;
    if (!this.paths.has(id)) this.paths.set(id, this.boxes.has(id) ? this.trace(id, this.boxes.get(id)) : null);
    return this.paths.get(id);
  }

  trace(id, [left, top, right, bottom]) {
    const { values, width, height } = this.ids;
    const is = (x, y) => x >= 0 && y >= 0 && x < width && y < height && values[y * width + x] === id;
    const path = new Path2D();
    const edges = (lines, places, differs, draw) => {
      for (let line = lines[0]; line <= lines[1]; line++) {
        for (let place = places[0], start = null; place <= places[1] + 1; place++) {
          const isEdge = place <= places[1] && differs(line, place);
          if (isEdge && start === null) start = place;
          if (!isEdge && start !== null) {
            draw(line, start, place);
            start = null;
          }
        }
      }
    };
    edges([top, bottom + 1], [left, right], (y, x) => is(x, y - 1) !== is(x, y), (y, from, to) => {
      path.moveTo(from, y);
      path.lineTo(to, y);
    });
    edges([left, right + 1], [top, bottom], (x, y) => is(x - 1, y) !== is(x, y), (x, from, to) => {
      path.moveTo(x, from);
      path.lineTo(x, to);
    });
    return path;
  }
}
