// The pixel under the pointer, the selected one and its story, and a pinned one beside it.

import { hex } from "/color.js";
import { make } from "/element.js";
import { byId, emit, fullSize, live, on, pixelQuery, report } from "/live.js";
import { light, markPath, nameOf, needOutlines, objectAt, openObject } from "/objects.js";
import { PASSES, valuesAt } from "/passes.js";
import { ServerError, get, newest } from "/server.js";
import { renderStory } from "/story.js";
import { shown, stage } from "/view.js";

let hovered = null;

export function hover(pixel) {
  hovered = pixel;
  if (live.isMoving) return;
  if (pixel) needOutlines();
  light(objectAt(pixel) ?? null);
  showSpot();
}

// Position, value, color and object of the pixel under the pointer, or else of the selected one.
function showSpot() {
  const pixel = hovered ?? live.pixel;
  if (!pixel || !live.picture) return;
  const { x, y } = pixel;
  const isIn = ({ width, height }) => x < width && y < height;
  const parts = [make("b", {}, `${x}, ${y}`)];
  const { pass, differs } = shown;
  const { picture } = live;
  const isFull = picture.width === fullSize().width;
  if (differs && isIn(picture)) parts.push(make("span", { className: "value" }, `differs by ${differs.levels[y * picture.width + x]}`));
  if (pass && isFull && isIn(pass.values)) {
    const { title, text } = PASSES[pass.name];
    parts.push(make("span", { className: "value" }, `${title} ${text(valuesAt(pass.values, x, y))}`));
  }
  if (isFull && isIn(picture)) {
    const color = picture.color(x, y);
    const swatch = make("i", { className: "swatch" });
    swatch.style.background = hex(color);
    parts.push(swatch, make("span", { className: "color" }, `${hex(color)}  ${color.join(" ")}`));
  }
  const index = objectAt(pixel);
  if (index === null) parts.push(make("span", { className: "name" }, "background"));
  else if (index !== undefined) parts.push(make("span", { className: "name" }, `${nameOf(index)} (id ${index + 1})`));
  byId("spot").replaceChildren(...parts);
}

on("picture", () => { if (!live.isMoving) showSpot(); });
on("shown", () => {
  if (hovered) light(objectAt(hovered) ?? null);
  showSpot();
});

// --- Selection, and the address --------------------------------------------------------------------------

export function select(pixel) {
  live.pixel = pixel;
  changed();
}

export function clickPixel(pixel, event) {
  if (event.shiftKey && live.pixel && !live.pin) live.pin = live.pixel;
  select(pixel);
}

export function move(dx, dy) {
  const { width, height } = fullSize();
  if (!width) return;
  const from = live.pixel ?? { x: Math.floor(width / 2) - dx, y: Math.floor(height / 2) - dy };
  const within = (value, size) => Math.min(Math.max(value, 0), size - 1);
  hovered = null;
  select({ x: within(from.x + dx, width), y: within(from.y + dy, height) });
  stage.reveal(live.pixel);
}

export function togglePin() {
  if (!live.pixel) return;
  live.pin = live.pin ? null : live.pixel;
  changed();
}

const text = (pixel) => `${pixel.x},${pixel.y}`;

function changed() {
  const { pixel, pin } = live;
  const hash = pixel ? `#pixel=${text(pixel)}${pin ? `&pin=${text(pin)}` : ""}` : "";
  if (location.hash !== hash) history.replaceState(null, "", hash || location.pathname);
  byId("pixel-none").hidden = pixel !== null;
  byId("pin").disabled = byId("clear").disabled = !pixel;
  byId("pin").ariaPressed = String(pin !== null);
  document.body.classList.toggle("two-stories", pin !== null);
  if (pixel) [byId("go-x").value, byId("go-y").value] = [pixel.x, pixel.y];
  if (pixel) needOutlines();
  stage.draw();
  showSpot();
  tell();
  emit("pixel", pixel);
}

export function followHash() {
  const pixelOf = (name) => {
    const match = new RegExp(`[#&]${name}=(\\d{1,5}),(\\d{1,5})(?=&|$)`).exec(location.hash);
    return match && { x: Number(match[1]), y: Number(match[2]) };
  };
  live.pin = pixelOf("pin");
  select(pixelOf("pixel"));
}

window.addEventListener("hashchange", followHash);
byId("pin").addEventListener("click", togglePin);
byId("clear").addEventListener("click", () => {
  live.pin = null;
  select(null);
});
byId("go").addEventListener("submit", (event) => {
  event.preventDefault();
  const [x, y] = [byId("go-x"), byId("go-y")].map((input) => input.valueAsNumber);
  if (!(Number.isInteger(x) && Number.isInteger(y))) return;
  select({ x, y });
  stage.reveal(live.pixel);
});

stage.overlays.push((context, port) => {
  for (const [pixel, letter] of [[live.pin, "A"], [live.pixel, live.pin ? "B" : ""]]) {
    if (pixel) drawMarker(context, port, pixel, letter);
  }
});

function drawMarker(context, port, { x, y }, letter) {
  const side = Math.max(stage.scale, 11);
  const left = port.left + (x + 0.5) * stage.scale - side / 2;
  const top = port.top + (y + 0.5) * stage.scale - side / 2;
  for (const [color, grow, width] of [["#000", 2, 1], ["#fff", 1, 2]]) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.strokeRect(left - grow, top - grow, side + 2 * grow, side + 2 * grow);
  }
  context.font = "bold 12px system-ui, sans-serif";
  context.lineWidth = 3;
  context.strokeStyle = "#000";
  context.strokeText(letter, left + side + 5, top + 4);
  context.fillStyle = "#fff";
  context.fillText(letter, left + side + 5, top + 4);
}

// --- Stories ---------------------------------------------------------------------------------------------

const stories = [
  { key: "pixel", box: byId("story-now"), title: "Pixel B" },
  { key: "pin", box: byId("story-pin"), title: "Pixel A" },
];

let isFromStory = false;

// Old stories stay until the new ones are there.
const tell = newest(async () => {
  for (const story of stories) await tellOne(story, live[story.key]);
}, report);

const FOCUSABLE = "button, input";

const isSamePixel = (story, { x, y }) => story.pixel?.x === x && story.pixel.y === y;

async function loadStory({ x, y }) {
  try {
    return await (await get("/pixel", { x, y, ...pixelQuery() })).text();
  } catch (error) {
    if (error instanceof ServerError) return JSON.stringify({ error: error.message });
    throw error;
  }
}

async function tellOne(story, pixel) {
  if (!pixel || !live.state?.picture) {
    story.box.hidden = true;
    story.text = story.handle = null;
    return;
  }
  const loaded = await loadStory(pixel);
  story.box.hidden = false;
  const [title, place] = story.box.children;
  title.hidden = !live.pin;
  title.textContent = story.title;
  if (loaded === story.text) return;
  story.text = loaded;
  const told = JSON.parse(loaded);
  const panel = byId("panel-pixel");
  const { scrollTop } = panel;
  const focused = [...place.querySelectorAll(FOCUSABLE)].indexOf(document.activeElement);
  const drawn = story.handle?.drawn();
  story.handle = told.error ? null : renderStory(place, told, {
    onHoverObject: (index) => {
      isFromStory = true; // which has lit up its own symbol
      light(index);
      isFromStory = false;
    },
    onHoverPath: markPath,
    onOpenLine: openObject,
  });
  if (told.error) place.replaceChildren(make("p", { className: "hint" }, told.error));
  place.querySelector(".verdict")?.after(...(told.notes ?? []).map((note) => make("p", { className: "hint" }, note)));
  if (drawn && isSamePixel(story, pixel)) story.handle?.draw(drawn);
  story.pixel = pixel;
  if (focused >= 0) place.querySelectorAll(FOCUSABLE)[focused]?.focus({ preventScroll: true });
  panel.scrollTop = scrollTop;
  if (story.key === "pixel") speak(`Pixel ${pixel.x}, ${pixel.y}. ${told.error ?? told.sentence ?? ""}`);
}

on("picture", () => { if (!live.isMoving) tell(); });
on("light", (index) => {
  if (!isFromStory) for (const { handle } of stories) handle?.highlightObject(index);
});

// The symbols of the story that the keys of the camera are about.
const SYMBOLS = { position: "o", look_at: "f", up: "u", fov: "fov", fov_x: "fov", resolution: "size", height: "height" };

let isLineLit = false;

on("line", ({ light: index = null, key }) => {
  if (index === null && !key && !isLineLit) return;
  isLineLit = index !== null || Boolean(key);
  for (const { handle } of stories) {
    if (key) handle?.highlightSymbol(SYMBOLS[key] ?? "o");
    else handle?.highlightLight(index);
  }
});

let speakTimer = 0;

// For screen readers, after a pause: a held arrow key would talk without end.
function speak(message) {
  clearTimeout(speakTimer);
  speakTimer = setTimeout(() => { byId("spoken").textContent = message; }, 400);
}
