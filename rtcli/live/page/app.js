// The page of `rtcli live`. Text from the scene goes into the page by textContent and the like only, never as HTML.

import * as camera from "/camera.js";
import { hex } from "/color.js";
import { BLACK, Picture, WHITE, canvasOf, difference, histogram } from "/image.js";
import { Outlines } from "/outline.js";
import { ObjectList, Tabs, byId, clippedText, counted, drawHistogram, element, showLegend } from "/panels.js";
import { PASSES, decodePass, paint, valuesAt } from "/passes.js";
import { Events, ServerError, get, getJson, newest, post } from "/server.js";
import { Source } from "/source.js";
import { Stage } from "/stage.js";
import { renderStory } from "/story.js";

const live = {
  state: null, // of the server
  picture: null, // the newest, as the view shows it
  before: null, // a promise of the picture before it
  passes: new Map(), // promises of passes, by name
  outlines: null,
  histogram: null,
  differs: null,
  exposure: null, // null: of the file
  pose: null, // null: of the file
  pivot: null, // the depth about which the camera turns
  size: null, // a smaller size while the camera moves
  pixel: null,
  pin: null,
  hovered: null, // a pixel
  lit: null, // the index of an object
  opened: null,
  flashing: [],
  isMoving: false,
};

const stage = new Stage(byId("stage"), byId("canvas"), {
  hover, select: clickPixel, drag: dragCamera, wheel: wheelCamera, drop: dropCamera, changed: showZoom, draw: drawOver,
});
const source = new Source(byId("text"), (line) => light(objectOfLine(line)));
const objectList = new ObjectList({ onHover: light, onOpen: openObject });
const tabs = new Tabs(document.querySelector(".tabs"), () => showHistogram());
const stories = { pin: { box: byId("story-pin") }, now: { box: byId("story-now") } };

// --- State from the server -------------------------------------------------------------------------------

function viewQuery() {
  const query = live.pose ? camera.query(live.pose) : {};
  if (live.size) query.size = live.size;
  return query;
}

function pictureQuery() {
  return live.exposure === null ? viewQuery() : { ...viewQuery(), exposure: live.exposure };
}

async function loadPicture(query) {
  return Picture.of(await get("/picture", query));
}

function report(error) {
  if (error instanceof ServerError) say(error.message);
  else if (!(error instanceof TypeError)) throw error; // a TypeError of fetch: the server is gone, which Events tells
}

// State and picture are fetched side by side, since the event says whether there is a new picture.
const refresh = newest(async (event) => {
  const start = performance.now();
  const shown = live.state?.picture;
  const isNew = event.picture !== null && (!shown || shown.preview || event.picture !== shown.version);
  const [state, picture] = await Promise.all([getJson("/state"), isNew ? loadPicture(pictureQuery()) : null]);
  takeState(state);
  if (picture) {
    await takePicture(picture);
    if (shown && state.picture && state.picture.version !== shown.version) {
      flash(state.changed);
      await new Promise(requestAnimationFrame);
      showLatency(state.picture.milliseconds + performance.now() - start);
    }
  }
}, report);

// For another view of the same state.
const look = newest(async () => {
  const start = performance.now();
  await takePicture(await loadPicture(pictureQuery()));
  adaptSize(performance.now() - start);
}, report);

async function takePicture(picture) {
  const old = live.picture;
  Object.assign(live, { picture, before: null, outlines: null, histogram: null });
  live.passes.clear();
  await present();
  if (old && old !== picture) setTimeout(() => old.bitmap.close(), 1000); // not before the last frame that shows it
  if (live.isMoving) return;
  showHistogram();
  showSpot();
  tell();
}

function takeState(state) {
  const old = live.state;
  live.state = state;
  document.title = `${state.scene} · rtcli live`;
  showName(state.scene);
  showStatus(state);
  showProblems(state);
  if (old?.text !== state.text || old?.text_of_picture !== state.text_of_picture) showText();
  if (JSON.stringify(old?.objects) !== JSON.stringify(state.objects)) objectList.show(state.objects);
  markProblems();
  showCommand();
  showExposure();
  showCamera();
}

function showName(path) {
  const end = Math.max(path.lastIndexOf("/"), path.lastIndexOf("\\")) + 1;
  byId("scene").replaceChildren(element("span", "folder", path.slice(0, end)), path.slice(end));
}

const STATUS = {
  ok: ({ picture }) => `Up to date, ${picture?.time}`,
  rendering: () => "Rendering",
  invalid: ({ problems }) => counted(problems.length, "problem"),
  missing: () => "File not found",
};

function showStatus(state) {
  const status = byId("status");
  status.className = `status ${state.status}`;
  const text = STATUS[state.status](state);
  if (status.textContent !== text) status.textContent = text;
  const isStale = state.status === "invalid" || state.status === "missing";
  byId("stage").classList.toggle("dimmed", isStale && state.picture !== null);
  const what = state.status === "missing" ? "the file is gone" : `line ${state.problems[0]?.line ?? 1}`;
  byId("stale").textContent = `${what}: picture of ${state.picture?.time}`;
  byId("stale").hidden = !isStale || !state.picture;
  byId("empty").hidden = state.picture !== null || state.problems.length > 0;
  byId("empty").textContent = state.status === "missing" ? `There is no file ${state.scene}` : "No picture yet";
  byId("note").textContent = "Preview: the full picture follows";
  byId("note").hidden = !state.picture?.preview;
}

function showProblems({ problems, report: text, status }) {
  byId("problems").hidden = problems.length === 0;
  byId("problems").classList.toggle("bad", status === "invalid");
  byId("problems-title").textContent = counted(problems.length, "problem");
  if (byId("report").textContent !== text) byId("report").textContent = text;
}

byId("problems-toggle").addEventListener("click", () => {
  const isShown = byId("report").hidden;
  byId("report").hidden = !isShown;
  byId("problems-toggle").ariaExpanded = String(isShown);
  byId("problems-toggle").textContent = isShown ? "Hide" : "Show";
});

function showLatency(milliseconds) {
  byId("latency").hidden = false;
  byId("latency").textContent = `${Math.round(milliseconds)} ms`;
}

new Events({
  onEvent: refresh,
  onOpen: () => { byId("gone").hidden = true; },
  onGone: (seconds, isRefused) => {
    byId("gone").hidden = false;
    byId("gone").firstChild.textContent = isRefused
      ? "The server was started again: open the address that it printed."
      : `The server is gone. The page tries again every ${seconds} s.`;
  },
});

// --- What the stage shows --------------------------------------------------------------------------------

const chosenPass = () => byId("pass").value;
const comparison = () => (chosenPass() === "picture" ? byId("compare").value : "off");

function loadPass(name) {
  if (!live.passes.has(name)) live.passes.set(name, get("/pass", { name, ...viewQuery() }).then(decodePass));
  return live.passes.get(name);
}

function loadBefore() {
  live.before ??= loadPicture({ ...pictureQuery(), version: "previous" }).catch((error) => {
    if (error instanceof ServerError) return null; // the first good version has none before it
    throw error;
  });
  return live.before;
}

// Returns images, layout and legend for what is chosen, loading what is missing.
async function compose() {
  const plain = { images: [live.picture.bitmap] };
  if (chosenPass() !== "picture") {
    const pass = await loadPass(chosenPass());
    const { canvas, legend } = paint(chosenPass(), pass);
    return { images: [canvas], legend, pass };
  }
  if (comparison() === "off") return plain;
  const before = await loadBefore();
  if (!before) return { ...plain, legend: { text: "There is no earlier picture: save a change first." } };
  if (comparison() !== "difference") return { images: [before.bitmap, live.picture.bitmap], layout: comparison() };
  const differs = difference(before, live.picture);
  if (!differs) return { ...plain, legend: { text: "The picture before has another size." } };
  if (!differs.count) return { images: [differs.canvas], differs, legend: { text: "No pixel differs." } };
  const unit = `levels of 255, the largest of three channels; ${counted(differs.count, "pixel differs", "pixels differ")}`;
  return { images: [differs.canvas], differs, legend: { low: 1, high: differs.most, unit } };
}

let shownPass = null; // of the frame on the screen, for the value under the pointer

async function present() {
  if (!live.picture) return;
  const { images, layout = "one", legend, pass = null, differs = null } = await compose();
  shownPass = pass && { name: chosenPass(), pass };
  live.differs = differs;
  const { width, height } = fullSize();
  stage.show(images, width, height, layout);
  stage.drawNow();
  showLegend(byId("legend"), legend);
  byId("split").hidden = layout !== "slider";
  byId("side-before").hidden = byId("side-now").hidden = layout === "one";
  byId("side-before").textContent = "before";
  byId("side-now").textContent = `now, ${live.state.picture?.time ?? ""}`;
  showSpot();
}

// The size of the scene: a preview and a picture of a moving camera are smaller.
function fullSize() {
  return live.state.picture ?? live.picture;
}

const presentNewest = newest(present, report);
byId("pass").append(
  new Option("picture", "picture"),
  ...Object.entries(PASSES).map(([name, { title }]) => new Option(title, name)),
);
byId("pass").addEventListener("change", presentNewest);
byId("compare").addEventListener("change", () => {
  if (byId("compare").value !== "off") byId("pass").value = "picture";
  presentNewest();
});
byId("split").addEventListener("input", () => {
  stage.split = byId("split").value / 100;
  stage.draw();
});

function showZoom() {
  byId("zoom").textContent = `${Number((stage.scale * stage.ratio * 100).toPrecision(3))} %`;
}

byId("zoom-in").addEventListener("click", () => stage.zoomIn());
byId("zoom-out").addEventListener("click", () => stage.zoomOut());
byId("zoom-fit").addEventListener("click", () => stage.fit());
byId("zoom-actual").addEventListener("click", () => stage.actual());

// --- Over the picture ------------------------------------------------------------------------------------

// Two strokes, dark and light and dashed, which are seen on any picture.
function strokeTwice(context, scale, stroke) {
  for (const [color, width, dashes] of [["#000", 4, []], ["#fff", 2, []], ["#000", 2, [4, 4]]]) {
    context.strokeStyle = color;
    context.lineWidth = width / scale;
    context.setLineDash(dashes.map((dash) => dash / scale));
    stroke();
  }
  context.setLineDash([]);
}

function drawOver(context, port) {
  if (isClippedShown()) drawClipped(context, port);
  context.save();
  context.translate(port.left, port.top);
  context.scale(stage.scale, stage.scale);
  const indices = new Set([...live.flashing, live.lit, live.opened].filter((index) => index !== null));
  for (const index of indices) {
    const path = live.outlines?.of(index);
    if (path) strokeTwice(context, stage.scale, () => context.stroke(path));
  }
  context.restore();
  for (const [pixel, letter] of [[live.pin, "A"], [live.pixel, live.pin ? "B" : ""]]) {
    if (pixel) drawMarker(context, port, pixel, letter);
  }
}

function drawMarker(context, port, { x, y }, letter) {
  const side = Math.max(stage.scale, 11);
  const left = port.left + (x + 0.5) * stage.scale - side / 2;
  const top = port.top + (y + 0.5) * stage.scale - side / 2;
  for (const [color, grow] of [["#000", 2], ["#fff", 1]]) {
    context.strokeStyle = color;
    context.lineWidth = 3 - grow;
    context.strokeRect(left - grow, top - grow, side + 2 * grow, side + 2 * grow);
  }
  if (!letter) return;
  context.font = "bold 12px system-ui, sans-serif";
  context.lineWidth = 3;
  context.strokeStyle = "#000";
  context.strokeText(letter, left + side + 5, top + 4);
  context.fillStyle = "#fff";
  context.fillText(letter, left + side + 5, top + 4);
}

// --- Objects ---------------------------------------------------------------------------------------------

// Outlines need the pass of ids: it is loaded when first asked for.
async function loadOutlines() {
  if (live.outlines || live.isMoving) return;
  const { picture } = live;
  const ids = await loadPass("object_id");
  if (picture !== live.picture || live.outlines) return;
  live.outlines = new Outlines(ids);
  if (live.hovered) light(objectAt(live.hovered));
  stage.draw();
  showSpot();
}

const needOutlines = newest(loadOutlines, report);

function objectAt(pixel) {
  const ids = live.outlines?.ids;
  const id = pixel && ids && pixel.x < ids.width && pixel.y < ids.height ? ids.values[pixel.y * ids.width + pixel.x] : 0;
  return id ? id - 1 : null;
}

function objectOfLine(line) {
  if (line === null || !isTextOfPicture()) return null;
  return live.state.objects.find(({ lines }) => lines && line >= lines[0] && line <= lines[1])?.index ?? null;
}

const nameOf = (index) => {
  const object = live.state.objects[index];
  return object ? object.name ?? object.label : `objects[${index}]`;
};

// Highlights an object everywhere: in the picture, the list, the text and the stories.
function light(index) {
  if (index === live.lit) return;
  live.lit = index;
  if (index !== null) needOutlines();
  stage.draw();
  objectList.mark("lit", index);
  markText("lit", live.state?.objects[index]?.lines);
  for (const story of Object.values(stories)) story.handle?.highlightObject(index);
}

function openObject(index) {
  live.opened = live.opened === index ? null : index;
  objectList.open(live.opened);
  const object = live.state.objects[live.opened];
  byId("edit").hidden = !object || !live.state.editor;
  byId("source-what").textContent = object ? nameOf(index) : "";
  if (object && live.state.text_of_picture !== null) chooseText("picture");
  markText("opened", object?.lines);
  if (object?.lines && isTextOfPicture()) source.reveal(object.lines);
  needOutlines();
  stage.draw();
}

byId("edit").addEventListener("click", () => post("/open", { index: live.opened }).catch(report));

function flash(indices) {
  if (!indices?.length) return;
  live.flashing = indices;
  needOutlines();
  setTimeout(() => {
    if (live.flashing === indices) live.flashing = [];
    stage.draw();
  }, 1600);
}

// --- Text ------------------------------------------------------------------------------------------------

const chosenText = () => document.querySelector("[name=text]:checked").value;
const isTextOfPicture = () => live.state?.text_of_picture == null || chosenText() === "picture";

function chooseText(value) {
  document.querySelector(`[name=text][value=${value}]`).checked = true;
  showText();
}

function showText() {
  const { text, text_of_picture: ofPicture } = live.state;
  byId("source-which").hidden = ofPicture == null;
  source.show((chosenText() === "picture" && ofPicture != null ? ofPicture : text) ?? "");
  markText("opened", live.state.objects[live.opened]?.lines);
  markProblems();
}

function markText(name, lines) {
  source.mark(name, isTextOfPicture() ? lines : null);
}

let firstProblem = null;

function markProblems() {
  const { problems, text_of_picture: ofPicture } = live.state;
  source.mark("wrong", null);
  const isShown = ofPicture == null || chosenText() === "now";
  if (isShown) for (const { line } of problems) source.element.children[line - 1]?.classList.add("wrong");
  const line = problems[0]?.line ?? null;
  if (isShown && line !== null && line !== firstProblem) source.reveal([line, line]);
  firstProblem = line;
}

document.querySelectorAll("[name=text]").forEach((radio) => radio.addEventListener("change", showText));

// --- Pixel -----------------------------------------------------------------------------------------------

function hover(pixel) {
  live.hovered = pixel;
  if (live.isMoving) return;
  if (pixel) needOutlines();
  light(objectAt(pixel));
  showSpot();
}

// Position, color, object and value of the pixel under the pointer, or else of the selected one.
function showSpot() {
  const pixel = live.hovered ?? live.pixel;
  const { picture } = live;
  if (!pixel || !picture) return;
  const parts = [element("b", "", `${pixel.x}, ${pixel.y}`)];
  if (live.differs) {
    parts.push(element("span", "", `differs by ${live.differs.levels[pixel.y * picture.width + pixel.x] ?? 0}`));
  }
  if (shownPass && pixel.x < shownPass.pass.width && pixel.y < shownPass.pass.height) {
    const { name, pass } = shownPass;
    parts.push(element("span", "value", `${PASSES[name].title} ${PASSES[name].text(valuesAt(pass, pixel.x, pixel.y))}`));
  }
  const { width, height } = fullSize();
  if (picture.width === width && pixel.x < width && pixel.y < height) {
    const color = picture.color(pixel.x, pixel.y);
    const swatch = element("i", "swatch");
    swatch.style.background = hex(color);
    parts.push(swatch, element("span", "", `${hex(color)}  ${color.join(" ")}`));
  }
  const index = objectAt(pixel);
  if (index !== null) parts.push(element("span", "name", `${nameOf(index)} (id ${index + 1})`));
  else if (live.outlines) parts.push(element("span", "name", "background"));
  byId("spot").replaceChildren(...parts);
}

function clickPixel(pixel, event) {
  if (event.shiftKey && live.pixel && !live.pin) live.pin = live.pixel;
  selectPixel(pixel);
}

function selectPixel(pixel) {
  live.pixel = pixel;
  if (pixel) tabs.open(byId("tab-pixel"));
  pixelChanged();
}

function pixelChanged() {
  const { pixel, pin } = live;
  const text = pixel ? `#pixel=${pixel.x},${pixel.y}${pin ? `&pin=${pin.x},${pin.y}` : ""}` : "";
  if (location.hash !== text) history.replaceState(null, "", text || location.pathname);
  byId("pixel-none").hidden = pixel !== null;
  byId("pin").disabled = byId("clear").disabled = !pixel;
  byId("pin").ariaPressed = String(pin !== null);
  byId("stories").classList.toggle("two", pin !== null);
  document.body.classList.toggle("two-stories", pin !== null);
  if (pixel) [byId("go-x").value, byId("go-y").value] = [pixel.x, pixel.y];
  stage.draw();
  showSpot();
  tell();
}

function followHash() {
  const pixelOf = (name) => {
    const match = new RegExp(`[#&]${name}=(\\d{1,5}),(\\d{1,5})(?=&|$)`).exec(location.hash);
    return match && { x: Number(match[1]), y: Number(match[2]) };
  };
  live.pin = pixelOf("pin");
  selectPixel(pixelOf("pixel"));
}

window.addEventListener("hashchange", followHash);

// Shows the story of the pixel, and of the pinned one. Old stories stay until the new ones are there.
const tell = newest(async () => {
  for (const [name, pixel] of [["now", live.pixel], ["pin", live.pin]]) await tellOne(stories[name], pixel);
}, report);

async function tellOne(story, pixel) {
  if (!pixel || !live.state?.picture) {
    story.box.hidden = true;
    story.text = null;
    return;
  }
  const { x, y } = pixel;
  let text;
  try {
    text = await (await get("/pixel", { x, y, ...pictureQuery() })).text();
  } catch (error) {
    if (!(error instanceof ServerError)) throw error;
    text = JSON.stringify({ error: error.message });
  }
  story.box.hidden = false;
  const letter = live.pin ? (story === stories.pin ? "A: " : "B: ") : "";
  story.box.querySelector("h3").textContent = `${letter}pixel ${x}, ${y}`;
  if (text === story.text) return;
  story.text = text;
  const told = JSON.parse(text);
  const place = story.box.querySelector(".story");
  const panel = byId("panel-pixel");
  const { scrollTop } = panel;
  story.handle = null;
  if (told.error) {
    place.replaceChildren(element("p", "hint", told.error));
  } else {
    story.handle = renderStory(place, told, {
      onHoverObject: light,
      onHoverLight: (index) => markText("lit", live.state.lights[index]?.lines),
      onOpenLine: (index) => { if (live.opened !== index) openObject(index); },
    });
    if (story === stories.now) speak(`Pixel ${x}, ${y}. ${told.sentence ?? ""}`);
  }
  panel.scrollTop = scrollTop;
}

function movePixel(dx, dy) {
  const { width, height } = fullSize() ?? {};
  if (!width) return;
  const from = live.pixel ?? { x: Math.floor(width / 2) - dx, y: Math.floor(height / 2) - dy };
  const within = (value, size) => Math.min(Math.max(value, 0), size - 1);
  live.hovered = null;
  selectPixel({ x: within(from.x + dx, width), y: within(from.y + dy, height) });
  stage.reveal(live.pixel);
  needOutlines();
}

function togglePin() {
  if (!live.pixel) return;
  live.pin = live.pin ? null : live.pixel;
  pixelChanged();
}

byId("pin").addEventListener("click", togglePin);
byId("clear").addEventListener("click", () => { live.pin = null; selectPixel(null); });
byId("go").addEventListener("submit", (event) => {
  event.preventDefault();
  const [x, y] = [byId("go-x"), byId("go-y")].map((input) => input.valueAsNumber);
  if (Number.isInteger(x) && Number.isInteger(y)) {
    selectPixel({ x, y });
    stage.reveal(live.pixel);
  }
});

// --- Exposure and histogram ------------------------------------------------------------------------------

function showExposure() {
  const ofFile = live.state.picture?.exposure ?? 0;
  const value = live.exposure ?? ofFile;
  for (const id of ["exposure", "exposure-number"]) {
    if (document.activeElement !== byId(id) || live.exposure === null) byId(id).value = Number(value.toFixed(3));
  }
  byId("exposure-reset").disabled = live.exposure === null;
  const { tone = "clip" } = live.state.picture ?? {};
  byId("exposure-what").textContent = live.exposure === null
    ? `As in the file; tone curve ${tone}.`
    : `View only: the file has ${Number(ofFile.toFixed(3))} EV; tone curve ${tone}.`;
  showViewOnly();
}

function setExposure(value) {
  live.exposure = value;
  showExposure();
  showCommand();
  look();
}

for (const id of ["exposure", "exposure-number"]) {
  byId(id).addEventListener("input", () => {
    const value = byId(id).valueAsNumber;
    if (!Number.isFinite(value)) return;
    byId(id === "exposure" ? "exposure-number" : "exposure").value = value;
    setExposure(value);
  });
}
byId("exposure-reset").addEventListener("click", () => setExposure(null));

function stepExposure(stops) {
  setExposure(Number(((live.exposure ?? live.state.picture?.exposure ?? 0) + stops).toFixed(3)));
}

const isClippedShown = () => byId("clipped").ariaPressed === "true";

function showHistogram() {
  const isShown = !byId("panel-exposure").hidden;
  if (!live.picture || !(isShown || isClippedShown())) return;
  live.histogram ??= histogram(live.picture);
  if (isShown) {
    drawHistogram(byId("histogram"), live.histogram);
    byId("histogram-text").textContent = clippedText(live.histogram);
  }
  stage.draw();
}

new ResizeObserver(showHistogram).observe(byId("histogram"));

function toggleClipped() {
  byId("clipped").ariaPressed = String(!isClippedShown());
  showHistogram();
  stage.draw();
  if (isClippedShown() && live.histogram && byId("panel-exposure").hidden) say(clippedText(live.histogram));
}

byId("clipped").addEventListener("click", toggleClipped);

// Stripes to the right for pixels that are too bright, to the left for black ones.
const stripes = Object.fromEntries([[WHITE, (x, y) => x + y], [BLACK, (x, y) => x - y]].map(([kind, line]) => {
  const pixels = new Uint8ClampedArray(4 * 64);
  for (let at = 0; at < 64; at++) {
    const isDark = (line(at % 8, Math.floor(at / 8)) & 7) < 4;
    pixels.set(isDark ? [0, 0, 0, 255] : [255, 255, 255, 255], 4 * at);
  }
  return [kind, canvasOf(pixels, 8, 8)];
}));

function drawClipped(context, port) {
  const { masks, width, height, canvases } = live.histogram ?? {};
  if (!masks) return;
  live.histogram.canvases = canvases ?? Object.fromEntries(
    Object.entries(masks).map(([kind, mask]) => [kind, canvasOf(mask, width, height)]),
  );
  for (const [kind, mask] of Object.entries(live.histogram.canvases)) {
    const layer = new OffscreenCanvas(stage.canvas.width, stage.canvas.height);
    const over = layer.getContext("2d");
    over.imageSmoothingEnabled = false;
    over.scale(stage.ratio, stage.ratio);
    over.drawImage(mask, port.left, port.top, stage.width * stage.scale, stage.height * stage.scale);
    over.globalCompositeOperation = "source-in";
    over.fillStyle = over.createPattern(stripes[kind], "repeat");
    over.fillRect(0, 0, stage.element.clientWidth, stage.element.clientHeight);
    context.drawImage(layer, 0, 0, stage.element.clientWidth, stage.element.clientHeight);
  }
}

// --- Camera ----------------------------------------------------------------------------------------------

const isCameraMode = () => document.querySelector("[name=mode]:checked").value === "camera";

function currentPose() {
  if (live.pose) return live.pose;
  const { position, look_at, up } = live.state.camera;
  const pose = { position, look_at, up };
  return live.pivot ? camera.aim(pose, live.pivot) : pose;
}

// The camera turns about the point in the middle of the picture.
async function findPivot() {
  if (live.pose || !live.picture) return;
  const { values, width, height } = await loadPass("depth");
  const depth = values[Math.floor(height / 2) * width + Math.floor(width / 2)];
  const seen = Number.isFinite(depth) ? depth : values.find(Number.isFinite);
  live.pivot = seen > 0 ? seen : null;
}

function setPose(pose) {
  live.pose = pose;
  showCamera();
  showCommand();
  look();
}

const MOVES = {
  orbit: (pose, x, y) => camera.orbit(pose, x * 0.087, y * 0.087),
  pan: (pose, x, y) => camera.pan(pose, x * 0.03, y * 0.03),
  dolly: (pose, _, y) => camera.dolly(pose, 1.1 ** y),
};

function moveCamera(name, x, y) {
  if (live.state?.camera) setPose(MOVES[name](currentPose(), x, y));
}

function dragCamera(dx, dy, event) {
  if (!isCameraMode() || !live.state?.camera) return false;
  live.isMoving = true;
  const share = 1 / (stage.height * stage.scale || 1);
  const { fov } = live.state.camera;
  const perHeight = 2 * Math.tan(((fov ?? 40) * Math.PI) / 360);
  if (event.shiftKey || event.buttons === 4) setPose(camera.pan(currentPose(), dx * share * perHeight, dy * share * perHeight));
  else if (event.altKey) setPose(camera.dolly(currentPose(), 4 ** (dy * share)));
  else setPose(camera.orbit(currentPose(), dx * share * Math.PI, dy * share * Math.PI));
  return true;
}

function wheelCamera(event) {
  if (!isCameraMode() || event.ctrlKey || !live.state?.camera) return false;
  setPose(camera.dolly(currentPose(), 2 ** ((event.deltaMode ? event.deltaY * 30 : event.deltaY) / 480)));
  return true;
}

function dropCamera() {
  if (!live.isMoving) return;
  live.isMoving = false;
  live.size = null;
  look();
}

const SMOOTH = 80; // milliseconds of a frame while the camera moves

// A slow scene moves in a smaller size, and gets its pixels back when the pointer is released.
function adaptSize(milliseconds) {
  if (!live.isMoving) return;
  const { width, height } = fullSize();
  const now = live.picture.width / width;
  const share = Math.min(1, Math.max(0.1, now * Math.sqrt(SMOOTH / milliseconds)));
  live.size = share > 0.8 ? null : `${Math.round(width * share)}x${Math.round(height * share)}`;
}

function showViewOnly() {
  const what = [live.pose && "camera", live.exposure !== null && "exposure"].filter(Boolean);
  byId("view-only").hidden = what.length === 0;
  byId("view-only").firstElementChild.textContent = `View only: ${what.join(" and ")}`;
}

function showCamera() {
  if (!live.state.camera) return;
  const { writable, projection, fov, lines } = live.state.camera;
  byId("camera-lines").textContent = camera.yaml(live.pose ?? live.state.camera);
  byId("camera-reset").disabled = !live.pose;
  byId("camera-write").hidden = !(live.state.write && writable);
  byId("camera-write").disabled = !live.pose;
  const angle = fov ? `, ${Number(fov.toPrecision(4))}° high` : "";
  const where = lines ? `, lines ${lines[0]} to ${lines[1]}` : "";
  byId("camera-what").textContent = live.pose
    ? "View only: the file has another camera. Put these lines into it to keep the view."
    : `As in the file${where}: ${projection}${angle}.`;
  showViewOnly();
}

function resetView() {
  Object.assign(live, { pose: null, exposure: null, size: null });
  showExposure();
  showCamera();
  showCommand();
  look();
}

document.querySelectorAll("[name=mode]").forEach((radio) => radio.addEventListener("change", modeChanged));

function modeChanged() {
  byId("stage").classList.toggle("camera", isCameraMode());
  byId("stage").ariaLabel = isCameraMode() ? "Picture: arrow keys orbit the camera" : "Picture: arrow keys move the pixel";
  if (isCameraMode()) {
    tabs.open(byId("tab-camera"));
    findPivot().catch(report);
  }
}

function toggleMode() {
  document.querySelector("[name=mode]:not(:checked)").checked = true;
  modeChanged();
}

for (const button of document.querySelectorAll("[data-move]")) {
  button.addEventListener("click", () => moveCamera(button.dataset.move, Number(button.dataset.x), Number(button.dataset.y)));
}
byId("view-reset").addEventListener("click", resetView);
byId("camera-reset").addEventListener("click", () => setPose(null));
byId("camera-copy").addEventListener("click", () => copy(byId("camera-lines").textContent, "The lines are copied"));
byId("camera-write").addEventListener("click", async () => {
  try {
    await post("/camera", { ...live.pose, version: live.state.version });
    live.pose = null;
    say("The camera is written into the file");
  } catch (error) {
    report(error);
  }
});

// --- Command ---------------------------------------------------------------------------------------------

function showCommand() {
  const parts = [live.state.command];
  if (live.exposure !== null) parts.push(`--exposure ${live.exposure}`);
  if (live.pose) {
    for (const name of ["position", "look_at", "up"]) parts.push(`--set 'camera.${name}=[${live.pose[name].join(", ")}]'`);
  }
  byId("command").textContent = parts.join(" ");
}

async function copy(text, message) {
  try {
    await navigator.clipboard.writeText(text);
    say(message);
  } catch {
    say("The browser did not allow copying: select the text instead.");
  }
}

byId("command-copy").addEventListener("click", () => copy(byId("command").textContent, "The command is copied"));

// --- Messages, theme, keys -------------------------------------------------------------------------------

let toastTimer = 0;

function say(message) {
  clearTimeout(toastTimer);
  byId("toast").textContent = message;
  toastTimer = setTimeout(() => { byId("toast").textContent = ""; }, 4000);
}

let speakTimer = 0;

// After a pause, since a held arrow key would talk without end.
function speak(message) {
  clearTimeout(speakTimer);
  speakTimer = setTimeout(() => { byId("spoken").textContent = message; }, 400);
}

const THEMES = ["system", "light", "dark"];

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  localStorage.setItem("rtcli-theme", theme);
  byId("theme").textContent = `Theme: ${theme}`;
  showHistogram();
}

function nextTheme() {
  setTheme(THEMES[(THEMES.indexOf(document.documentElement.dataset.theme) + 1) % THEMES.length]);
}

function nextOption(select) {
  select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
  select.dispatchEvent(new Event("change"));
}

function escape() {
  if (live.opened !== null) openObject(live.opened);
  else if (live.pin) togglePin();
  else if (live.pixel) selectPixel(null);
}

function arrow(x, y) {
  return (event) => {
    if (!isCameraMode()) movePixel(x * (event.shiftKey ? 10 : 1), y * (event.shiftKey ? 10 : 1));
    else if (event.shiftKey) moveCamera("pan", x, y);
    else moveCamera("orbit", x, y);
  };
}

// What the dialog shows, and what each key does.
const KEYS = [
  ["← ↑ ↓ →", "Select a pixel, or orbit the camera; with Shift: by 10, or pan", {
    ArrowLeft: arrow(-1, 0), ArrowRight: arrow(1, 0), ArrowUp: arrow(0, -1), ArrowDown: arrow(0, 1),
  }],
  ["+ −", "Zoom in, zoom out", { "+": () => stage.zoomIn(), "=": () => stage.zoomIn(), "-": () => stage.zoomOut() }],
  ["0 1", "Fit the picture, actual pixels", { 0: () => stage.fit(), 1: () => stage.actual() }],
  ["P", "Pin the pixel, and put the next one beside it", { p: togglePin }],
  ["Esc", "Close the object, the pin, the pixel", { Escape: escape }],
  ["V", "Next pass", { v: () => nextOption(byId("pass")) }],
  ["D", "Compare with the picture before: next way", { d: () => nextOption(byId("compare")) }],
  ["H", "Hatch clipped pixels", { h: toggleClipped }],
  ["[ ]", "Exposure down, up by a quarter of a stop", { "[": () => stepExposure(-0.25), "]": () => stepExposure(0.25) }],
  ["C", "Switch between Inspect and Move camera", { c: toggleMode }],
  ["PgUp PgDn", "Camera closer, farther", { PageUp: () => moveCamera("dolly", 0, -1), PageDown: () => moveCamera("dolly", 0, 1) }],
  ["R", "Reset camera and exposure to the file's", { r: resetView }],
  ["/", "Filter the objects", { "/": () => { tabs.open(byId("tab-objects")); byId("find").focus(); } }],
  ["T", "Next theme", { t: nextTheme }],
  ["?", "This list", { "?": () => byId("keys").showModal() }],
];
const actions = Object.assign({}, ...KEYS.map(([, , each]) => each));
// These also scroll, or move what has the focus: they belong to the picture only while nothing else has it.
const PLACED = /^(Arrow|Page)/;

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
  const { target } = event;
  if (target.matches("input:not([type=radio], [type=range]), textarea")) return;
  if (PLACED.test(event.key) && !(target === document.body || target === byId("stage"))) return;
  const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action || !live.state) return;
  event.preventDefault();
  action(event);
});

for (const [keys, text] of KEYS) {
  const row = byId("keys-list").appendChild(element("p"));
  row.append(element("i"), element("span", "", text));
  row.firstChild.append(...keys.split(" ").map((key) => element("kbd", "", key)));
}
byId("help").addEventListener("click", () => byId("keys").showModal());
byId("keys-close").addEventListener("click", () => byId("keys").close());
byId("theme").addEventListener("click", nextTheme);
byId("retry").addEventListener("click", () => location.reload());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", showHistogram);

setTheme(document.documentElement.dataset.theme);
followHash();
