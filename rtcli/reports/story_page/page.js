import { renderStory } from "./story.js";

// The page that `rtcli explain --html` writes: the story beside the lines of the scene's file.

const { story, lines, paths } = JSON.parse(document.getElementById("data").textContent);
const pane = document.getElementById("lines");
const rows = new Map();

// Returns what lights up the part of the drawing that a line is about, and null puts it out.
function highlightOf(number) {
  const isWithin = (path) => paths[path][0] <= number && number <= paths[path][1];
  for (const path of Object.keys(paths).filter(isWithin)) {
    const [, kind, index] = path.match(/^(objects|lights)\[(\d+)\]$/) ?? [];
    if (kind === "objects") return (isOn) => view.highlightObject(isOn ? Number(index) : null);
    if (kind === "lights") return (isOn) => view.highlightLight(isOn ? Number(index) : null);
    if (path === "camera") return (isOn) => view.highlightSymbol(isOn ? "o" : null);
  }
  return null;
}

for (const [number, text] of lines) {
  const row = document.createElement("div");
  const count = document.createElement("span");
  const code = document.createElement("code");
  count.textContent = number;
  count.className = "count";
  code.textContent = text;
  row.append(count, code);
  rows.set(number, row);
  const highlight = highlightOf(number);
  if (highlight) {
    row.addEventListener("pointerenter", () => highlight(true));
    row.addEventListener("pointerleave", () => highlight(false));
  }
  pane.append(row);
}

// Marks the lines of a value, or of the nearest value around it that the file has.
function mark(path) {
  rows.forEach((row) => row.classList.remove("is-lit"));
  let known = path;
  while (known && !(known in paths)) known = known.replace(/\.?[^.[\]]+\]?$/, "").replace(/\[$/, "");
  if (!known) return;
  const [first, last] = paths[known];
  for (let number = first; number <= last; number += 1) rows.get(number)?.classList.add("is-lit");
  bringIntoSight(rows.get(first));
}

function bringIntoSight(row) {
  if (!row || pane.scrollHeight <= pane.clientHeight) return;
  const [top, bottom] = [row.offsetTop - pane.offsetTop, row.offsetTop - pane.offsetTop + row.offsetHeight];
  if (top < pane.scrollTop || bottom > pane.scrollTop + pane.clientHeight) pane.scrollTop = top - pane.clientHeight / 3;
}

const view = renderStory(document.getElementById("story"), story, {
  onHoverPath: mark,
  onOpenLine: (index) => {
    mark(`objects[${index}]`);
    rows.get(paths[`objects[${index}]`]?.[0])?.scrollIntoView({ block: "nearest" });
  },
});
