// Objects: their list, their outlines in the picture, and their lines in the text of the file.

import { make } from "/element.js";
import { byId, emit, fullSize, live, loadPass, on, report } from "/live.js";
import { Outlines } from "/outline.js";
import { newest, post } from "/server.js";
import { Source } from "/source.js";
import { stage } from "/view.js";

export const nameOf = (index) => {
  const object = live.state.objects[index];
  return object ? object.name ?? object.label : `objects[${index}]`;
};

// Highlights an object everywhere.
export function light(index) {
  if (index === live.lit) return;
  live.lit = index;
  if (index !== null) needOutlines();
  emit("light", index);
}

export function openObject(index) {
  live.opened = index;
  if (index !== null) needOutlines();
  emit("open", index);
}

// --- Outlines --------------------------------------------------------------------------------------------

let outlines = null;
let flashing = [];

// They need the pass of ids: it is loaded when first asked for.
export const needOutlines = newest(async () => {
  if (outlines || live.isMoving || !live.picture) return;
  const { picture } = live;
  const ids = await loadPass("object_id");
  if (picture !== live.picture || ids.width !== fullSize().width) return; // too large a view is smaller
  outlines = new Outlines(ids);
  stage.draw();
  emit("shown");
}, report);

on("picture", () => {
  outlines = null;
  if (live.pixel || live.lit !== null || live.opened !== null || flashing.length) needOutlines();
});

// The index of the object; null for the background, undefined while that is not known.
export function objectAt(pixel) {
  const { values, width, height } = outlines?.ids ?? {};
  if (!values || !pixel || pixel.x >= width || pixel.y >= height) return undefined;
  const id = values[pixel.y * width + pixel.x];
  return id ? id - 1 : null;
}

const FLASH = 1600; // milliseconds

export function flash(indices) {
  if (!indices.length) return;
  flashing = indices;
  needOutlines();
  setTimeout(() => {
    if (flashing === indices) flashing = [];
    stage.draw();
  }, FLASH);
}

// Dark, light and dashed, which is seen on any picture.
const STROKES = [["#000", 4, []], ["#fff", 2, []], ["#000", 2, [4, 4]]];

stage.overlays.push((context, port) => {
  context.translate(port.left, port.top);
  context.scale(stage.scale, stage.scale);
  for (const index of new Set([...flashing, live.lit, live.opened])) {
    const path = index === null ? null : outlines?.of(index);
    if (!path) continue;
    for (const [color, width, dashes] of STROKES) {
      context.strokeStyle = color;
      context.lineWidth = width / stage.scale;
      context.setLineDash(dashes.map((dash) => dash / stage.scale));
      context.stroke(path);
    }
  }
});

// --- The list --------------------------------------------------------------------------------------------

const list = byId("objects");

let listed = []; // the objects as the list has them

// Only while it can be seen, and only what changed: a scene may have ten thousand objects.
function showList() {
  const { objects } = live.state;
  byId("object-count").textContent = objects.length.toLocaleString("en");
  if (byId("panel-objects").hidden) return;
  while (list.children.length > objects.length) list.lastChild.remove();
  objects.forEach((object, index) => {
    if (JSON.stringify(listed[index]) === JSON.stringify(object)) return;
    const item = list.children[index] ?? list.appendChild(row(index));
    const [name, type, pixels, lines] = item.firstChild.children;
    name.textContent = object.name ?? object.label;
    type.textContent = object.type;
    pixels.textContent = object.pixels ? `${object.pixels.toLocaleString("en")} px` : "not seen";
    lines.textContent = object.lines ? `line ${object.lines[0]}` : "";
  });
  listed = objects;
  filter();
  markRow("lit", live.lit);
  markRow("opened", live.opened);
}

function row(index) {
  const parts = ["name", "type", "pixels", "lines"].map((className) => make("span", { className }));
  return make("li", {}, make("button", { type: "button", className: "object-row", dataset: { index } }, ...parts));
}

function filter() {
  const words = byId("find").value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  listed.forEach(({ name, label, type }, index) => {
    const text = `${name ?? ""} ${label} ${type}`.toLowerCase();
    const isShown = words.every((word) => text.includes(word));
    list.children[index].hidden = !isShown;
    count += isShown;
  });
  byId("objects-none").hidden = count > 0;
}

function markRow(name, index) {
  list.querySelector(`.${name}`)?.classList.remove(name);
  const button = list.children[index ?? -1]?.firstChild;
  button?.classList.add(name);
  return button;
}

const indexOf = (event) => {
  const button = event.target.closest?.("button");
  return button ? Number(button.dataset.index) : null;
};

for (const name of ["pointerover", "focusin"]) list.addEventListener(name, (event) => light(indexOf(event)));
for (const name of ["pointerleave", "focusout"]) list.addEventListener(name, () => light(null));
list.addEventListener("click", (event) => {
  const index = indexOf(event);
  if (index !== null) openObject(index === live.opened ? null : index);
});
byId("find").addEventListener("input", filter);

on("panel", showList);
on("state", () => {
  showList();
  if (live.opened >= live.state.objects.length) openObject(null);
});
on("light", (index) => markRow("lit", index));
on("open", (index) => {
  list.querySelector("[aria-current]")?.removeAttribute("aria-current");
  markRow("opened", index)?.setAttribute("aria-current", "true");
  byId("edit").hidden = index === null || !live.state.editor;
  byId("source-what").textContent = index === null ? "" : nameOf(index);
});
byId("edit").addEventListener("click", () => post("/open", { index: live.opened }).catch(report));

// --- The text of the file --------------------------------------------------------------------------------

const source = new Source(byId("text"), pointAtLine);
const choices = document.querySelectorAll("[name=text]");
const isChosen = (value) => document.querySelector("[name=text]:checked").value === value;

// The lines of objects are those of the text that the picture shows.
const isOfPicture = () => live.state?.text_of_picture == null || isChosen("picture");

// An object lights up everywhere, a light and the camera in the stories: `line` gives the index of the light, or the
// key of the camera.
function pointAtLine(number) {
  const { objects, lights, camera } = live.state ?? {};
  const isAt = (item) => item?.lines && isOfPicture() && number >= item.lines[0] && number <= item.lines[1];
  const found = number === null ? null : objects.find(isAt);
  light(found?.index ?? null);
  if (found) return;
  const key = number !== null && isAt(camera) ? /(\w+)\s*:/.exec(source.texts[number - 1])?.[1] : null;
  emit("line", { light: number === null ? null : lights.find(isAt)?.index ?? null, key });
}

function showText() {
  const { text, text_of_picture: ofPicture, objects } = live.state;
  byId("source-which").hidden = ofPicture == null;
  source.show((isOfPicture() ? ofPicture ?? text : text) ?? "");
  markLines("opened", objects[live.opened]?.lines);
  markProblems();
}

function markLines(name, lines) {
  source.mark(name, isOfPicture() ? lines : null);
}

// The lines of a value, such as `objects[3].radius`: the line of its key, or else all lines of what it belongs to.
export function markPath(path) {
  const [, list, index, key] = /^(?:(objects|lights)\[(\d+)\]|camera)(?:\.(\w+))?/.exec(path ?? "") ?? [];
  const lines = list ? live.state[list][index]?.lines : path?.startsWith("camera") ? live.state.camera.lines : null;
  const found = key && lines ? source.linesOf(key, lines) : lines;
  markLines("lit", found);
  if (found && isOfPicture()) source.reveal(found);
}

let firstProblem = null;

function markProblems() {
  const isShown = live.state.text_of_picture == null || isChosen("now");
  const numbers = isShown ? live.state.problems.map(({ line }) => line) : [];
  const isInvalid = live.state.status === "invalid";
  source.markAll("wrong", isInvalid ? numbers : []);
  source.markAll("warned", isInvalid ? [] : numbers);
  if (isInvalid && numbers.length && numbers[0] !== firstProblem) source.reveal(numbers);
  firstProblem = numbers[0] ?? null;
}

choices.forEach((radio) => radio.addEventListener("change", showText));
on("state", (old) => {
  if (old?.text !== live.state.text || old.text_of_picture !== live.state.text_of_picture) showText();
  else markProblems();
});
on("light", (index) => markLines("lit", live.state.objects[index]?.lines));
on("open", (index) => {
  if (index !== null && !isOfPicture()) {
    [...choices].find(({ value }) => value === "picture").checked = true;
    showText();
  }
  const lines = live.state.objects[index]?.lines;
  markLines("opened", lines);
  if (lines) source.reveal(lines);
});
