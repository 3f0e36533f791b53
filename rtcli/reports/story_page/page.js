import { renderStory } from "./story.js";

// The page that `rtcli explain --html` writes: the story beside the lines of the scene's file.

const { story, lines, paths } = JSON.parse(document.getElementById("data").textContent);
const pane = document.getElementById("lines");
const rows = new Map();

// Of values within each other, the innermost: `objects[3]`, not `objects`.
function pathOfLine(number) {
  const found = Object.entries(paths).filter(([, [first, last]]) => first <= number && number <= last);
  found.sort(([, a], [, b]) => a[1] - a[0] - (b[1] - b[0]));
  return found.map(([path]) => path).find((path) => /^(objects|lights)\[\d+\]$/.test(path)) ?? null;
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
  const [, kind, index] = pathOfLine(number)?.match(/^(objects|lights)\[(\d+)\]$/) ?? [];
  if (kind) {
    const show = (isOn) => {
      if (kind === "objects") view.highlightObject(isOn ? Number(index) : null);
      else view.highlightLight(isOn ? Number(index) : null);
    };
    row.addEventListener("pointerenter", () => show(true));
    row.addEventListener("pointerleave", () => show(false));
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
