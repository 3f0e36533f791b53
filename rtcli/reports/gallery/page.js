
"use strict";

import { make } from "./element.js";
import { followPixel, onKeys, valueAt } from "./parts.js";

// Text from the manifest goes into the page by textContent and the like only, never as HTML.

const byId = (id) => document.getElementById(id);
const { scenes, settings } = JSON.parse(byId("data").textContent);
const list = byId("cards");
const cards = [...list.children];
const links = cards.map((card) => card.firstElementChild);
const indexOfHash = new Map(links.map((link, index) => [link.hash, index]));

// --- Filter and order ------------------------------------------------------------------------------------

const nameInput = byId("name");
const orders = {
  name: cards.map((_, index) => index), // as the page has them
  // The slowest first.
  time: cards.map((_, index) => index).sort((a, b) => total(scenes[b]) - total(scenes[a])),
};
const names = scenes.map((scene) => scene.key.toLowerCase());
let shown = orders.name; // the indices of the cards that can be seen, in their order

function total(scene) {
  return scene.seconds.reduce((sum, [, seconds]) => sum + seconds, 0);
}

function filter() {
  const words = nameInput.value.toLowerCase().split(/\s+/).filter(Boolean);
  const status = document.querySelector("[name=status]:checked").value;
  const matches = (index) =>
    (status === "all" || scenes[index].done === (status === "done")) &&
    words.every((word) => names[index].includes(word));
  shown = orders[byId("sort").value].filter(matches);
  const visible = new Set(shown);
  cards.forEach((card, index) => { card.hidden = !visible.has(index); });
  byId("none").hidden = shown.length > 0;
  byId("count").textContent = `${shown.length.toLocaleString("en")} of ${cards.length.toLocaleString("en")} shown`;
}

function sort() {
  list.append(...orders[byId("sort").value].map((index) => cards[index]));
  filter();
}

function reset() {
  nameInput.value = "";
  document.querySelector("[name=status][value=all]").checked = true;
  filter();
  nameInput.focus();
}

nameInput.addEventListener("input", filter);
document.querySelectorAll("[name=status]").forEach((radio) => radio.addEventListener("change", filter));
byId("sort").addEventListener("change", sort);
byId("reset").addEventListener("click", reset);

// --- Keys in the list ------------------------------------------------------------------------------------

function columns() {
  return getComputedStyle(list).gridTemplateColumns.split(" ").length;
}

function moved(key, place) {
  switch (key) {
    case "ArrowLeft": return place - 1;
    case "ArrowRight": return place + 1;
    case "ArrowUp": return place - columns();
    case "ArrowDown": return place + columns();
    case "Home": return 0;
    case "End": return shown.length - 1;
    default: return -1;
  }
}

list.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
  const index = links.indexOf(document.activeElement);
  const place = moved(event.key, shown.indexOf(index));
  if (index < 0 || !(place in shown)) return;
  event.preventDefault();
  links[shown[place]].focus();
});

nameInput.addEventListener("keydown", (event) => {
  if ((event.key === "ArrowDown" || event.key === "Enter") && shown.length > 0) {
    event.preventDefault();
    links[shown[0]].focus();
  }
});

onKeys({
  "/": () => {
    nameInput.select();
    nameInput.focus();
  },
}, () => !details.open);

// --- Details ---------------------------------------------------------------------------------------------

const details = byId("details");
const body = byId("details-body");
let current = -1;

function seconds(value) {
  return value < 0.9995 ? `${(value * 1000).toFixed(value < 0.00995 ? 1 : 0)} ms` : `${value.toFixed(2)} s`;
}

function bytes(count) {
  if (count === null) return "";
  if (count < 1000) return `${count} B`;
  return count < 999500 ? `${Math.round(count / 1000)} kB` : `${(count / 1e6).toFixed(1)} MB`;
}

function section(title, content) {
  return content ? [make("h3", { textContent: title }), content] : [];
}

function pairs(rows) {
  if (rows.length === 0) return null;
  const cells = ([name, value]) => [make("dt", { textContent: name }), make("dd", {}, make("code", { textContent: value }))];
  return make("dl", {}, ...rows.flatMap(cells));
}

function times(scene) {
  if (scene.seconds.length === 0) return null;
  const all = total(scene);
  const cells = ([stage, value]) => {
    const bar = make("div", { className: "bar-of" });
    bar.style.width = all > 0 ? `max(1px, ${(100 * value) / all}%)` : "1px";
    return [
      make("dt", { textContent: stage }),
      make("dd", { ariaHidden: "true" }, bar),
      make("dd", { className: "number", textContent: seconds(value) }),
    ];
  };
  const sum = [
    make("dt", { className: "total", textContent: "total" }),
    make("dd", { className: "number", textContent: seconds(all) }),
  ];
  return make("dl", { className: "times" }, ...scene.seconds.flatMap(cells), ...sum);
}

function fileLine(file) {
  const name = file.url === null
    ? make("span", { className: "path", textContent: file.path })
    : make("a", { className: "path", href: file.url, textContent: file.path });
  const told = file.url === null ? "not found" : bytes(file.size);
  return make("li", {}, name, " ", make("small", { textContent: told }));
}

function problemLine(problem) {
  const title = make("div", { textContent: problem.message });
  const place = [problem.place, problem.pointer, problem.code].filter(Boolean).join(" · ");
  const more = [problem.help && `help: ${problem.help}`, place];
  return make("li", {}, title, ...more.filter(Boolean).map((text) => make("small", { textContent: text })));
}

function listOf(className, items) {
  return items.length === 0 ? null : make("ul", { className }, ...items);
}

// Of a picture that browsers cannot show there is the one in small; and so of the passes in its file.
function pictures(index) {
  const { passes } = scenes[index];
  const files = [...scenes[index].files.filter((file) => file.picture), ...passes];
  const small = links[index].querySelector("img");
  if (!small || files.some((file) => file.part === "radiance")) return files;
  return [{ part: "radiance", url: small.src, path: null }, ...files];
}

function figure(index) {
  const files = pictures(index);
  if (files.length === 0) return null;
  const image = make("img");
  const caption = make("figcaption");
  const spot = make("output", { className: "spot" });
  followPixel(image, (pixel) => {
    const value = pixel && valueAt(image, pixel);
    spot.textContent = pixel ? `x ${pixel[0]}, y ${pixel[1]}${value === null ? "" : `: ${value}`}` : "";
  });
  const buttons = files.map((file) => {
    const button = make("button", { type: "button" }, make("img", { src: file.url, alt: "" }), file.part);
    button.addEventListener("click", () => show(file));
    return button;
  });
  function show(file) {
    const isSmall = file.path === null;
    const told = isSmall
      ? "Thumbnail: browsers cannot show this format."
      : make("a", { className: "path", href: file.url, textContent: file.path });
    Object.assign(image, { src: file.url, alt: `${file.part} of ${scenes[index].key}`, className: isSmall ? "small" : "" });
    caption.replaceChildren(told);
    buttons.forEach((button, place) => button.setAttribute("aria-pressed", files[place] === file));
  }
  show(files[0]);
  const strip = make("div", { className: "strip", role: "group", ariaLabel: "Passes" }, ...buttons);
  return make("figure", {}, make("div", { className: "view" }, image), spot, caption, ...(files.length > 1 ? [strip] : []));
}

function fill(index) {
  const scene = scenes[index];
  byId("details-name").textContent = scene.key;
  const place = shown.indexOf(index);
  byId("details-place").textContent = place < 0 ? "" : `${place + 1} of ${shown.length}`;
  byId("previous").disabled = !(place - 1 in shown);
  byId("next").disabled = !(place + 1 in shown);
  const about = [["Status", scene.done ? "done" : "failed"], ["Scene", scene.scene], ["Size", scene.size], ["Software", scene.software]];
  const facts = make(
    "div",
    { className: "facts-column" },
    ...section("Problems", listOf("problems", scene.problems.map(problemLine))),
    ...section("Varied", pairs(scene.vary)),
    ...section("Time", times(scene)),
    ...section("Files", listOf("files", scene.files.map(fileLine))),
    ...section("Settings", pairs(settings[scene.settings])),
    ...section("About", pairs([...about.filter(([, value]) => value), ...scene.hashes])),
  );
  body.replaceChildren(...[figure(index), facts].filter(Boolean));
  details.scrollTop = 0;
}

function indexFromAddress() {
  const index = indexOfHash.get(location.hash);
  if (index !== undefined || location.hash === "") return index;
  try { // typed by hand, with other characters escaped
    const key = decodeURIComponent(location.hash.slice(1));
    return indexOfHash.get(`#${encodeURIComponent(key)}`) ?? scenes.findIndex((scene) => scene.key === key);
  } catch {
    return undefined;
  }
}

// The address says what is open, so that it can be kept and passed on.
function follow() {
  const index = indexFromAddress() ?? -1;
  if (index < 0) {
    details.close();
    return;
  }
  current = index;
  fill(index);
  if (!details.open) details.showModal();
}

function step(by) {
  const place = shown.indexOf(current);
  if (place < 0 || !(place + by in shown)) return;
  history.replaceState(null, "", links[shown[place + by]].hash);
  follow();
}

byId("previous").addEventListener("click", () => step(-1));
byId("next").addEventListener("click", () => step(1));
byId("close").addEventListener("click", () => details.close());
// Of the document: a button that is switched off as it is pressed leaves the focus to nobody.
onKeys({ ArrowLeft: () => step(-1), ArrowRight: () => step(1) }, () => details.open);
details.addEventListener("click", (event) => {
  if (event.target === details) details.close(); // beside it
});
details.addEventListener("close", () => {
  body.replaceChildren();
  if (location.hash) history.replaceState(null, "", location.pathname + location.search);
  if (current >= 0 && !cards[current].hidden) links[current].focus();
});
window.addEventListener("hashchange", follow);
// A browser that comes back to the page may have kept what was typed.
sort();
follow();
