// Draws the geometry of a pixel's story, as rtcli.explain.drawing computes it, in SVG.
//
// Text from scenes goes into the page by textContent only. Parts that a symbol of the story stands for have its name
// in data-symbol, objects their index in data-object, and the light its index in data-light.

const SVG = "http://www.w3.org/2000/svg";
const ARROW = 44; // the length of a unit vector, px
const LINE = 15; // the height of a line of text, px
const CHARACTER = 6.9; // about the width of a character, px
const LONGEST = 26; // characters of a name
const MOST_OTHERS = 6; // the objects that do not matter but have a name
const SMALL = 16; // px: an object less large has no name, unless it matters
const STEEP = 0.97; // a normal with less than this in the plane leans out of it

const SCALES = {
  linear: "",
  logarithmic: "Number line on a logarithmic scale.",
  in_order: "Number line in order, not to scale.",
};

export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

export function shown(value) {
  const size = Math.abs(value);
  if (size >= 1e7 || (size > 0 && size < 1e-4)) return value.toExponential(3).replace("e+", "e").replaceAll("-", "−");
  return Number(value.toPrecision(4)).toLocaleString("en", { maximumSignificantDigits: 4 }).replace("-", "−");
}

function cut(text) {
  return text.length > LONGEST ? `${text.slice(0, LONGEST - 1)}…` : text;
}

// --- Geometry in the plane -------------------------------------------------------------------------------

const along = ([x, y], [dx, dy], length) => [x + length * dx, y + length * dy];

// The part of a convex polygon, or of a line of two points, in a rectangle.
function clipped(points, [left, top, right, bottom]) {
  const closed = points.length > 2;
  const sides = [([x]) => x - left, ([x]) => right - x, ([, y]) => y - top, ([, y]) => bottom - y];
  return sides.reduce((kept, height) => kept.flatMap((point, i) => {
    const before = i > 0 || closed ? kept[(i + kept.length - 1) % kept.length] : point;
    const [h, g] = [height(point), height(before)];
    const crossing = (h < 0) === (g < 0) ? [] : [along(before, [point[0] - before[0], point[1] - before[1]], g / (g - h))];
    return h < 0 ? crossing : [...crossing, point];
  }), points);
}

// From inside a rectangle in a direction: the length to its edge.
function lengthToEdge([x, y], [dx, dy], [left, top, right, bottom]) {
  const lengths = [];
  if (dx !== 0) lengths.push(((dx > 0 ? right : left) - x) / dx);
  if (dy !== 0) lengths.push(((dy > 0 ? bottom : top) - y) / dy);
  return Math.max(0, Math.min(...lengths));
}

function isInside([x, y], [left, top, right, bottom]) {
  return x >= left && x <= right && y >= top && y <= bottom;
}

// --- Labels ----------------------------------------------------------------------------------------------

// Places texts beside points so that they do not cover each other; the first come first.
class Labels {
  constructor(width, height) {
    this.bounds = [4, 4, width - 4, height - 4];
    this.taken = [];
    this.elements = [];
  }

  // Keep other labels off a line.
  avoid(from, to) {
    const steps = Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1]) / 12);
    for (let i = 0; i <= steps; i += 1) {
      const [x, y] = along(from, [to[0] - from[0], to[1] - from[1]], i / Math.max(1, steps));
      this.taken.push([x - 3, y - 3, x + 3, y + 3]);
    }
  }

  add([x, y], text, attributes = {}, isNeeded = true) {
    const shortText = cut(text);
    const w = shortText.length * CHARACTER;
    const free = [];
    for (const gap of isNeeded ? [8, 16, 30, 48] : [4, 10]) {
      free.push([x + gap, y - gap - LINE], [x - w - gap, y - gap - LINE], [x + gap, y + gap], [x - w - gap, y + gap]);
      free.push([x - w / 2, y - gap - LINE], [x - w / 2, y + gap], [x + gap, y - LINE / 2], [x - w - gap, y - LINE / 2]);
    }
    const boxes = free.map(([left, top]) => [left, top, left + w, top + LINE]);
    const fits = (box) => box[0] >= this.bounds[0] && box[1] >= this.bounds[1] && box[2] <= this.bounds[2] && box[3] <= this.bounds[3];
    const covers = (box) => this.taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3]);
    const box = boxes.find((each) => fits(each) && !covers(each)) ?? (isNeeded ? boxes.find(fits) : undefined);
    if (!box) return;
    this.taken.push(box);
    const element = svg("text", { x: box[0], y: box[1] + LINE - 3, ...attributes });
    element.textContent = shortText;
    if (shortText !== text) element.append(titled(text));
    this.elements.push(element);
  }
}

function titled(text) {
  const title = svg("title");
  title.textContent = text;
  return title;
}

// --- A section -------------------------------------------------------------------------------------------

// Returns the words for a section, which readers without the picture hear.
export function described(drawing, section) {
  const seen = section.outlines.find((outline) => outline.role === "seen");
  const parts = [`The plane through the ray${section.shadow_ray ? ` and ${section.shadow_ray.label}` : ""}; lengths are true.`];
  if (section.t === null) {
    parts.push(`From ${drawing.start} the ray hits nothing.`);
  } else {
    parts.push(`From ${drawing.start} the ray meets ${seen ? seen.object.label : "a surface"} at t = ${shown(section.t)}.`);
    if (Math.hypot(...section.normal) < STEEP) parts.push("The normal n leans out of this plane, so it looks shorter.");
  }
  const way = section.shadow_ray;
  if (way) {
    const far = way.distance === null ? "infinitely far away" : `${shown(way.distance)} away`;
    const stops = way.stops.map((stop) => `${stop.object.label} at ${shown(stop.distance)} from the point`);
    const verdicts = {
      lit: "its light reaches the point",
      blocked: stops.length ? `its light is blocked by ${stops.join(", ")}` : "its light is blocked",
      turned_away: "the surface faces away from it",
      other_side: "it is on the other side of the surface",
    };
    parts.push(`${way.label} is ${far}: ${verdicts[way.verdict]}.`);
  }
  return parts.join(" ");
}

// Returns the height, in px, that a view of a section needs at a width.
export function heightOf({ views }, viewIndex, width) {
  const [left, bottom, right, top] = (views[viewIndex] ?? views[0]).box;
  const margin = marginOf(width);
  const height = ((width - 2 * margin) * (top - bottom)) / (right - left) + 2 * margin;
  return Math.round(Math.min(Math.max(0.34 * width, 190, height), 0.52 * width + 60, 440));
}

function marginOf(width) {
  return Math.min(64, width / 7);
}

// Returns an SVG element of the size, in px, that shows a view of a section.
export function drawSection(drawing, section, viewIndex, [width, height]) {
  const [left, bottom, right, top] = (section.views[viewIndex] ?? section.views[0]).box;
  const margin = marginOf(width);
  const scale = Math.min((width - 2 * margin) / Math.max(right - left, 1e-300), (height - 2 * margin) / Math.max(top - bottom, 1e-300));
  const middle = [(left + right) / 2, (bottom + top) / 2];
  const place = ([x, y]) => [width / 2 + (x - middle[0]) * scale, height / 2 - (y - middle[1]) * scale];
  const turned = ([x, y]) => [x, -y]; // directions: y points down on the screen
  const frame = [0, 0, width, height];
  const inner = [10, 10, width - 10, height - 10];
  const labels = new Labels(width, height);
  const root = svg("svg", { class: "section", viewBox: `0 0 ${width} ${height}`, width, height, role: "img" });
  const pattern = `hatch-${patterns += 1}`;
  const lower = [];
  const upper = [];

  const start = place([0, 0]);
  const ray = turned(section.ray);
  const point = section.t === null ? null : place([section.t * section.ray[0], section.t * section.ray[1]]);

  // --- Outlines

  for (const { object, role, points } of section.outlines) {
    const all = points.map(place);
    const seen = clipped(all, frame);
    if (seen.length < 2) continue;
    const path = all.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" ");
    const shape = svg(points.length > 2 ? "polygon" : "polyline", {
      class: `outline ${role}`, fill: role === "blocks" ? `url(#${pattern})` : undefined, points: path, "data-object": object.index, "data-symbol": role === "seen" ? "object" : undefined,
    }, titled(role === "blocks" ? `${object.label}, which blocks the light` : object.label));
    lower.push([role, shape, object, seen]);
  }
  const order = ["other", "blocks", "seen"];
  lower.sort((a, b) => order.indexOf(a[0]) - order.indexOf(b[0]));

  // --- The ray

  const arrow = (from, direction, length, attributes) => {
    const end = along(from, direction, length);
    const side = [-direction[1], direction[0]];
    const back = along(end, direction, -8);
    const head = [end, along(back, side, 3.5), along(back, side, -3.5)];
    return svg("g", attributes,
      svg("line", { x1: from[0], y1: from[1], x2: back[0], y2: back[1] }),
      svg("polygon", { points: head.map((each) => each.join(",")).join(" ") }));
  };
  const line = (from, to, attributes) => svg("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1], ...attributes });
  const dot = ([cx, cy], attributes, r = 4.5) => svg("circle", { cx, cy, r, ...attributes });

  // A line may be longer than an SVG can hold: draw what is in sight.
  const visible = (from, to) => {
    const ends = clipped([from, to], [-20, -20, width + 20, height + 20]);
    return ends.length === 2 ? ends : null;
  };
  const far = along(start, ray, 4 * (width + height) + (point ? Math.hypot(point[0] - start[0], point[1] - start[1]) : 0));
  const rest = visible(point ?? start, far);
  const way = point && visible(start, point);
  if (rest) upper.push(line(...rest, { class: point ? "ray rest" : "ray", "data-symbol": point ? undefined : "t" }));
  if (way) {
    upper.push(line(...way, { class: "ray", "data-symbol": "t" }));
    labels.avoid(...way);
  }

  // --- Shadow ray

  const shadow = section.shadow_ray;
  const unit = shadow && turned(shadow.toward);
  if (shadow && point) {
    const edge = lengthToEdge(point, unit, inner);
    const full = shadow.distance === null ? Infinity : shadow.distance * scale;
    const end = along(point, unit, Math.min(full, edge));
    const isHere = full <= edge;
    const first = shadow.stops[0];
    const cutAt = first ? Math.min(first.distance * scale, edge) : 0;
    const data = { "data-symbol": "l", "data-light": shadow.light };
    labels.avoid(point, end);
    if (shadow.half_angle > 0) {
      for (const sign of [-1, 1]) {
        const [s, c] = [Math.sin(sign * shadow.half_angle), Math.cos(shadow.half_angle)];
        const to = [unit[0] * c - unit[1] * s, unit[0] * s + unit[1] * c];
        const length = shadow.distance === null ? Infinity : full * c;
        upper.push(line(point, along(point, to, Math.min(length, lengthToEdge(point, to, frame))), { class: "wedge" }));
      }
    }
    const isStopped = shadow.verdict !== "lit" || shadow.stops.length > 0;
    if (isStopped) upper.push(line(point, along(point, unit, first ? cutAt : Math.min(full, edge)), { class: "shadow cut", ...data }));
    if (first ? cutAt < Math.min(full, edge) : !isStopped) {
      upper.push(line(along(point, unit, cutAt), end, { class: "shadow", ...data }));
    }
    if (isStopped) {
      const [x, y] = along(point, unit, first ? cutAt : 14);
      const cross = [[-5, -5, 5, 5], [-5, 5, 5, -5]].map(([x1, y1, x2, y2]) => line([x + x1, y + y1], [x + x2, y + y2], {}));
      upper.push(svg("g", { class: "cross" }, ...cross));
    }
    if (isHere) {
      const radius = Math.max(6, full * Math.sin(shadow.half_angle));
      upper.push(dot(end, { class: shadow.half_angle > 0 ? "lamp wide" : "lamp", "data-symbol": "position", "data-light": shadow.light }, radius));
      labels.add(end, shadow.label, { class: "label", "data-light": shadow.light });
    } else {
      upper.push(arrow(along(end, unit, -10), unit, 10, { class: "shadow", "data-symbol": "position", "data-light": shadow.light }));
      labels.add(end, shadow.distance === null ? `${shadow.label} (a sun)` : `${shadow.label}, ${shown(shadow.distance)} away`, { class: "label", "data-light": shadow.light });
    }
  }

  // --- Vectors and points

  if (point && isInside(point, frame)) {
    const n = turned(section.normal);
    const length = Math.hypot(...n);
    if (length > 0.05) {
      const tip = along(point, n, ARROW);
      upper.push(arrow(point, n.map((x) => x / length), ARROW * length, { class: "vector", "data-symbol": "n" }));
      labels.add(tip, "n", { class: "label symbol-label", "data-symbol": "n" });
    }
    if (shadow) {
      upper.push(arrow(point, unit, ARROW, { class: "vector light", "data-symbol": "l", "data-light": shadow.light }));
      labels.add(along(point, unit, ARROW), "l", { class: "label symbol-label", "data-symbol": "l" });
      if (length >= STEEP) {
        const [from, to] = [along(point, n, 0.5 * ARROW), along(point, unit, 0.5 * ARROW)];
        const sweep = n[0] * unit[1] - n[1] * unit[0] > 0 ? 1 : 0;
        upper.push(svg("path", { class: "angle", d: `M${from} A${0.5 * ARROW},${0.5 * ARROW} 0 0 ${sweep} ${to}`, "data-symbol": "cos_theta" }, titled("theta")));
      }
    }
    upper.push(dot(point, { class: "point", "data-symbol": "P" }));
    labels.add(point, `P, t = ${shown(section.t)}`, { class: "label", "data-symbol": "P" });
  }
  if (isInside(start, frame)) {
    upper.push(arrow(start, ray, ARROW, { class: "vector", "data-symbol": "d" }));
    labels.add(along(start, ray, ARROW), "d", { class: "label symbol-label", "data-symbol": "d" });
    upper.push(dot(start, { class: "eye", "data-symbol": "o" }, 6));
    labels.add(start, drawing.start === "the eye" ? "eye" : "start", { class: "label", "data-symbol": "o" });
  } else if (way) {
    const edge = along(point, ray.map((x) => -x), lengthToEdge(point, ray.map((x) => -x), inner));
    labels.add(edge, `from ${drawing.start}`, { class: "label", "data-symbol": "o" });
  }
  for (const { t, object } of drawing.number_line.marks) {
    const at = place([t * section.ray[0], t * section.ray[1]]);
    if ((t - section.t) * scale > 9 && isInside(at, frame)) upper.push(dot(at, { class: "mark", "data-object": object.index }, 3));
  }

  // --- Names of objects, those that matter first

  let others = 0;
  for (const [role, , object, seen] of [...lower].reverse()) {
    if (object.index === shadow?.body?.index) continue; // the light has its label
    const [xs, ys] = [0, 1].map((axis) => seen.map((each) => each[axis]));
    const size = Math.hypot(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys));
    if (role === "other" && (size < SMALL || (others += 1) > MOST_OTHERS)) continue;
    const sum = seen.reduce(([x, y], each) => [x + each[0], y + each[1]], [0, 0]);
    const at = seen.length === 2
      ? along(seen[0], [seen[1][0] - seen[0][0], seen[1][1] - seen[0][1]], seen[0][0] < seen[1][0] ? 0.15 : 0.85)
      : [sum[0] / seen.length, sum[1] / seen.length];
    labels.add(at, object.label, { class: `label name ${role}`, "data-object": object.index }, role !== "other");
  }
  root.append(hatch(pattern), ...lower.map(([, shape]) => shape), ...upper, ...labels.elements);
  return root;
}

// What blocks is hatched, so that it is not told by its color alone.
let patterns = 0;

function hatch(id) {
  const pattern = svg("pattern", { id, width: 7, height: 7, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    svg("line", { class: "hatch", x1: 0, y1: 0, x2: 0, y2: 7 }));
  return svg("defs", {}, pattern);
}

// --- The number line -------------------------------------------------------------------------------------

// Returns an SVG element, or null if the ray hits nothing.
export function drawNumberLine(drawing, width) {
  const { marks, scale, more } = drawing.number_line;
  if (marks.length === 0) return null;
  const [left, right] = [30, width - 24];
  const rows = []; // the right end of the last text in each row
  const items = [];
  const texts = marks.map(({ object, t }) => [`t = ${shown(t)}`, cut(object.label)]);
  marks.forEach((mark, i) => {
    const x = left + (right - left) * mark.place;
    const w = CHARACTER * Math.max(...texts[i].map((text) => text.length));
    const from = Math.min(Math.max(4, x - w / 2), width - w - 4);
    let row = rows.findIndex((end) => end + 8 <= from);
    if (row < 0) row = rows.push(0) - 1;
    rows[row] = from + w;
    items.push({ ...mark, x, from, w, row, lines: texts[i] });
  });
  const axis = 14;
  const height = axis + 14 + rows.length * 2 * LINE + 8;
  const root = svg("svg", { class: "number-line", viewBox: `0 0 ${width} ${height}`, width, height, role: "img" });
  root.append(
    svg("line", { class: "axis", x1: left, y1: axis, x2: right + 14, y2: axis }),
    svg("circle", { class: "eye", cx: left, cy: axis, r: 5, "data-symbol": "o" }),
  );
  const zero = svg("text", { class: "label", x: 4, y: axis + 4 });
  zero.textContent = "0";
  root.append(zero);
  for (const { object, x, from, w, row, lines } of items) {
    const top = axis + 12 + row * 2 * LINE;
    const isFirst = object.index === items[0].object.index;
    const group = svg("g", { class: isFirst ? "mark-on-line nearest" : "mark-on-line", "data-object": object.index },
      svg("line", { class: "leader", x1: x, y1: axis, x2: x, y2: top + 2 }),
      svg("circle", { cx: x, cy: axis, r: isFirst ? 5 : 4 }));
    lines.forEach((text, i) => {
      const element = svg("text", { class: "label", x: from + w / 2, y: top + (i + 1) * LINE - 2, "text-anchor": "middle" });
      element.textContent = text;
      group.append(element);
    });
    root.append(group);
  }
  const told = marks.map(({ object, t }) => `${object.label} at ${shown(t)}`).join(", ");
  root.prepend(titled(`The ray as a number line: ${told}${more ? `, ${more} more behind these` : ""}.`));
  return root;
}

export function scaleNote(drawing) {
  const { scale, more } = drawing.number_line;
  return [SCALES[scale], more ? `${more.toLocaleString("en")} more hits behind these.` : ""].filter(Boolean).join(" ");
}
