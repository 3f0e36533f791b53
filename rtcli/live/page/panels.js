// Parts of the page that show a state and know nothing of each other.

import { number, viridis } from "/color.js";
import { BLACK, WHITE } from "/image.js";

export const byId = (id) => document.getElementById(id);

export function element(tag, name, text) {
  const made = document.createElement(tag);
  if (name) made.className = name;
  if (text !== undefined) made.textContent = text;
  return made;
}

export const counted = (count, one, many = `${one}s`) => `${count.toLocaleString("en")} ${count === 1 ? one : many}`;

const share = (count, total) => {
  const percent = (100 * count) / total;
  return percent && percent < 0.01 ? "less than 0.01 %" : `${Number(percent.toPrecision(2))} %`;
};

// --- Tabs ------------------------------------------------------------------------------------------------

export class Tabs {
  constructor(list, onOpen) {
    this.tabs = [...list.children];
    this.onOpen = onOpen;
    for (const tab of this.tabs) tab.addEventListener("click", () => this.open(tab));
    list.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const index = this.tabs.indexOf(event.target) + step + this.tabs.length;
      this.open(this.tabs[index % this.tabs.length]);
      this.current.focus();
    });
  }

  get current() {
    return this.tabs.find((tab) => tab.ariaSelected === "true");
  }

  open(opened) {
    for (const tab of this.tabs) {
      tab.ariaSelected = String(tab === opened);
      tab.tabIndex = tab === opened ? 0 : -1;
      byId(tab.getAttribute("aria-controls")).hidden = tab !== opened;
    }
    this.onOpen(opened.id);
  }
}

// --- Objects ---------------------------------------------------------------------------------------------

export class ObjectList {
  // Handlers: onHover(index or null), onOpen(index).
  constructor({ onHover, onOpen }) {
    Object.assign(this, { objects: [], list: byId("objects"), opened: null });
    const indexOf = (event) => {
      const button = event.target.closest?.("button");
      return button ? Number(button.dataset.index) : null;
    };
    for (const name of ["pointerover", "focusin"]) this.list.addEventListener(name, (event) => onHover(indexOf(event)));
    for (const name of ["pointerleave", "focusout"]) this.list.addEventListener(name, () => onHover(null));
    this.list.addEventListener("click", (event) => {
      if (indexOf(event) !== null) onOpen(indexOf(event));
    });
    byId("find").addEventListener("input", () => this.filter());
  }

  show(objects) {
    this.objects = objects;
    while (this.list.children.length > objects.length) this.list.lastChild.remove();
    objects.forEach((object, index) => {
      const item = this.list.children[index] ?? this.list.appendChild(this.row(index));
      const [name, type, pixels, lines] = item.firstChild.children;
      name.textContent = object.name ?? object.label;
      type.textContent = object.type;
      pixels.textContent = object.pixels ? `${object.pixels.toLocaleString("en")} px` : "not seen";
      lines.textContent = object.lines ? `line ${object.lines[0]}` : "";
    });
    byId("object-count").textContent = objects.length.toLocaleString("en");
    this.filter();
  }

  row(index) {
    const item = element("li");
    const button = item.appendChild(element("button", "object"));
    button.type = "button";
    button.dataset.index = index;
    button.append(...["name", "type", "pixels", "lines"].map((name) => element("span", name)));
    return item;
  }

  filter() {
    const words = byId("find").value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    this.objects.forEach(({ name, label, type }, index) => {
      const text = `${name ?? ""} ${label} ${type}`.toLowerCase();
      const isShown = words.every((word) => text.includes(word));
      this.list.children[index].hidden = !isShown;
      count += isShown;
    });
    byId("objects-none").hidden = count > 0;
  }

  mark(name, index) {
    for (const button of this.list.querySelectorAll(`.${name}`)) button.classList.remove(name);
    const button = this.list.children[index ?? -1]?.firstChild;
    button?.classList.add(name);
    return button;
  }

  open(index) {
    this.list.querySelector("[aria-current]")?.removeAttribute("aria-current");
    this.mark("opened", index)?.setAttribute("aria-current", "true");
  }
}

// --- Histogram -------------------------------------------------------------------------------------------

// A line for each channel, told apart by its dashes too; the height is the square root of the count.
const LINES = [[".red", []], [".green", [6, 3]], [".blue", [2, 2]]];

export function drawHistogram(canvas, { bins }) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  // The ends, which hold what is clipped, do not decide the height.
  const most = Math.max(...bins.flatMap((counts) => [...counts.subarray(1, 255)]), 1);
  const y = (count) => height - 2 - (height - 6) * Math.min(Math.sqrt(count / most), 1);
  LINES.forEach(([name, dashes], channel) => {
    context.strokeStyle = getComputedStyle(document.querySelector(`.key ${name}`)).stroke;
    context.lineWidth = 1.5;
    context.setLineDash(dashes);
    context.beginPath();
    bins[channel].forEach((count, level) => context.lineTo(1 + ((width - 2) * level) / 255, y(count)));
    context.stroke();
  });
}

export function clippedText({ counts, width, height }) {
  const total = width * height;
  const part = (count) => `${counted(count, "pixel")} (${share(count, total)})`;
  return `Clipped: ${part(counts[WHITE])} with a channel at 255, ${part(counts[BLACK])} black.`;
}

// --- Legend ----------------------------------------------------------------------------------------------

export function showLegend(place, legend) {
  place.hidden = !legend;
  if (!legend) return;
  if (legend.text) {
    place.replaceChildren(element("span", "", legend.text));
    return;
  }
  const bar = element("canvas");
  [bar.width, bar.height] = [128, 1];
  const context = bar.getContext("2d");
  for (let x = 0; x < bar.width; x++) {
    context.fillStyle = `rgb(${viridis(x / (bar.width - 1))})`;
    context.fillRect(x, 0, 1, 1);
  }
  bar.ariaHidden = "true";
  const ends = [legend.low, legend.high].map((value) => element("b", "", number(value, 3)));
  place.replaceChildren(ends[0], bar, ends[1], element("span", "", legend.unit));
}
